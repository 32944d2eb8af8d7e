//! Pictures as PDF: the drawing of an SVG on one page, with the embedded font and document information.

use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref, TextStr};
use svg2pdf::usvg::{Options, Tree};
use svg2pdf::{ConversionOptions, to_chunk};

use super::error::PlotError;
use super::file_options::{NATURAL_DPI, PROGRAM, PROVENANCE, TITLE};
use super::picture::DEJAVU_SANS;

const POINTS_PER_INCH: f32 = 72.0;

/// Converts an SVG of the embedded font to a PDF, with its metadata as document information: `Title`, `Creator` (the
/// program), and `Provenance`, an entry of this program.
pub(super) fn of_svg(svg: &str, metadata: &[(&str, String)]) -> Result<Vec<u8>, PlotError> {
    let mut options = Options::default();
    options.fontdb_mut().load_font_data(DEJAVU_SANS.to_vec());
    let tree = Tree::from_str(svg, &options).map_err(|error| PlotError::Drawing(error.to_string()))?;
    let (drawing, root) =
        to_chunk(&tree, ConversionOptions::default()).map_err(|error| PlotError::Drawing(error.to_string()))?;
    let [catalogue, pages, page, content, information] = [1, 2, 3, 4, 5].map(Ref::new);
    // The converter also numbers its objects from 1, so they are renumbered. The order of its dictionaries is
    // arbitrary.
    let after_ours = |old: Ref| Ref::new(old.get() + information.get());
    let drawing = drawing.renumber(after_ours);
    let [width, height] =
        [tree.size().width(), tree.size().height()].map(|side| side * POINTS_PER_INCH / NATURAL_DPI as f32);
    let mut pdf = Pdf::new();
    pdf.catalog(catalogue).pages(pages);
    pdf.pages(pages).kids([page]).count(1);
    let name = Name(b"Picture");
    let mut sheet = pdf.page(page);
    sheet.media_box(Rect::new(0.0, 0.0, width, height)).parent(pages).contents(content);
    sheet.resources().x_objects().pair(name, after_ours(root));
    sheet.finish();
    // The drawing is one unit wide and high.
    let mut painted = Content::new();
    painted.transform([width, 0.0, 0.0, height, 0.0, 0.0]).x_object(name);
    pdf.stream(content, &painted.finish());
    let mut about = pdf.document_info(information);
    for (keyword, text) in metadata {
        match *keyword {
            TITLE => {
                about.title(TextStr(text));
            }
            PROGRAM => {
                about.creator(TextStr(text));
            }
            PROVENANCE => {
                about.pair(Name(b"Provenance"), TextStr(text));
            }
            _ => {}
        }
    }
    about.finish();
    pdf.extend(&drawing);
    Ok(pdf.finish())
}
