//! Public names of the library: their number, and the types in their signatures.
//!
//! A public name is a type, trait, function, constant or macro with a documented path: all modules of the path and the
//! name itself are `pub` without `#[doc(hidden)]`. A name with two such paths counts twice; names of optional features
//! count; modules, methods, fields and variants do not.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use syn::visit::{Visit, visit_path, visit_signature};
use syn::{Attribute, ImplItem, Item, ItemUse, TraitItem, Type, UseTree, Visibility};

/// Most public names.
const MOST_NAMES: usize = 250;

/// Documented enums that are complete, so that a `match` in the program and the Python extension covers every case.
const COMPLETE_ENUMS: [&str; 7] =
    ["Blocking", "Earthshine", "Illumination", "MagnitudeLimit", "Seeing", "VerdictKind", "Viewpoint"];

/// Documented structs that users write as literals: inputs and options. Users end those with a default in
/// `..Default::default()`, so that fields can be added. All other structs with public fields are results.
const COMPLETE_STRUCTS: [&str; 62] = [
    "Brightness",
    "Chip",
    "ClearWindow",
    "ElementSet",
    "EphemerisRequest",
    "EphemerisRow",
    "Exposure",
    "FileOptions",
    "FitPoint",
    "FitSettings",
    "FlagReport",
    "FlagRequest",
    "Forecast",
    "ForecastRequest",
    "Glint",
    "IdentifyOptions",
    "LightCurve",
    "LocalClock",
    "Magnitude",
    "MeasureOptions",
    "MeasuredDelay",
    "Measurement",
    "Measurements",
    "Modulation",
    "Night",
    "NightTimeline",
    "NoradId",
    "Offset",
    "Optics",
    "Orientation",
    "PassOptions",
    "PassPoint",
    "PathNode",
    "PhotometryOptions",
    "PixelPosition",
    "Policy",
    "PosteriorSettings",
    "PredictedStreak",
    "RandomStreaks",
    "RawWeights",
    "ReadOptions",
    "ScheduleOptions",
    "ScheduledExposure",
    "Selection",
    "Shot",
    "SkyChart",
    "SkyPoint",
    "SkyTrack",
    "SnapshotOptions",
    "Source",
    "SourcePart",
    "StandardMagnitude",
    "State",
    "StreakImage",
    "Telescope",
    "Tumbling",
    "TwoPanelForm",
    "Verdict",
    "ViewingGeometry",
    "VisibleRequest",
    "WindowRequest",
    "WindowTarget",
];

/// Crates whose types may be in documented signatures.
const KNOWN_CRATES: [&str; 5] = ["alloc", "core", "hifitime", "serde_json", "std"];

/// Path of a module or a name from the root of the crate, such as `["passes", "Sky"]`.
type Names = Vec<String>;

/// Source files of the library by module.
type Files = BTreeMap<Names, syn::File>;

fn names(path: &[&str]) -> Names {
    path.iter().map(|&name| name.to_owned()).collect()
}

fn below(module: &[String], name: &str) -> Names {
    module.iter().cloned().chain([name.to_owned()]).collect()
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

/// Returns true if one of the attributes is `#[name(word)]`.
fn has(attributes: &[Attribute], name: &str, word: &str) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident(name) && attribute.parse_args::<syn::Ident>().is_ok_and(|argument| argument == word)
    })
}

/// Returns name and visibility of an item that defines a name.
fn definition(item: &Item) -> Option<(String, &Visibility)> {
    let (name, visibility) = match item {
        Item::Const(item) => (&item.ident, &item.vis),
        Item::Enum(item) => (&item.ident, &item.vis),
        Item::Fn(item) => (&item.sig.ident, &item.vis),
        Item::Static(item) => (&item.ident, &item.vis),
        Item::Struct(item) => (&item.ident, &item.vis),
        Item::Trait(item) => (&item.ident, &item.vis),
        Item::Type(item) => (&item.ident, &item.vis),
        _ => return None,
    };
    Some((name.to_string(), visibility))
}

/// Appends the names of a `use` tree, each with its path.
fn leaves(tree: &UseTree, path: &[String], found: &mut Vec<(String, Names)>) {
    match tree {
        UseTree::Path(tree) => leaves(&tree.tree, &below(path, &tree.ident.to_string()), found),
        UseTree::Name(tree) if tree.ident == "self" => {
            found.extend(path.last().map(|name| (name.clone(), path.to_vec())))
        }
        UseTree::Name(tree) => found.push((tree.ident.to_string(), below(path, &tree.ident.to_string()))),
        UseTree::Rename(tree) => found.push((tree.rename.to_string(), below(path, &tree.ident.to_string()))),
        UseTree::Group(group) => group.items.iter().for_each(|tree| leaves(tree, path, found)),
        UseTree::Glob(_) => found.push(("*".to_owned(), path.to_vec())),
    }
}

fn imported(item: &ItemUse) -> Vec<(String, Names)> {
    let mut found = Vec::new();
    leaves(&item.tree, &[], &mut found);
    found
}

/// Returns the documented names below a module, and those that are public but hidden from the documentation.
fn public_names(files: &Files, module: &[String], hidden: bool, found: &mut [BTreeSet<Names>; 2]) {
    for item in &files[module].items {
        let hidden = hidden || has(attributes(item), "doc", "hidden");
        let names: Vec<String> = match item {
            Item::Mod(item) if matches!(item.vis, Visibility::Public(_)) => {
                public_names(files, &below(module, &item.ident.to_string()), hidden, found);
                Vec::new()
            }
            Item::Use(item) if matches!(item.vis, Visibility::Public(_)) => {
                imported(item).into_iter().map(|(name, _)| name).collect()
            }
            Item::Macro(item) if item.attrs.iter().any(|attribute| attribute.path().is_ident("macro_export")) => {
                item.ident.iter().map(ToString::to_string).collect()
            }
            item => definition(item)
                .filter(|(_, visibility)| matches!(visibility, Visibility::Public(_)))
                .map(|(name, _)| vec![name])
                .unwrap_or_default(),
        };
        found[usize::from(hidden)].extend(names.iter().map(|name| below(module, name)));
    }
}

/// Reads all files of `src/` without the command line program.
fn source_files(folder: &Path, module: &[String], files: &mut Files) {
    for entry in fs::read_dir(folder).expect("a folder of src") {
        let path = entry.expect("an entry of src").path();
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        if path.is_dir() && !(module.is_empty() && name == "bin") {
            source_files(&path, &below(module, &name), files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let module = if ["mod", "lib"].contains(&name.as_str()) { module.to_vec() } else { below(module, &name) };
            let text = fs::read_to_string(&path).expect("a source file");
            files.insert(module, syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display())));
        }
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns the files of the library, and its documented and hidden public names.
fn library() -> (Files, [BTreeSet<Names>; 2]) {
    let mut files = Files::new();
    source_files(&root().join("src"), &[], &mut files);
    let mut found = Default::default();
    public_names(&files, &[], false, &mut found);
    (files, found)
}

/// Returns the path at which a name is defined, given a path in the code of a module; for a name of another crate, the
/// name of the crate and `None`; nothing for names that the module neither defines nor imports, such as type
/// parameters.
fn defined(files: &Files, module: &[String], path: &[String]) -> Option<(Names, Option<Names>)> {
    let supers = path.iter().take_while(|name| *name == "super").count();
    let (start, rest) = match path.first()?.as_str() {
        "crate" => (&module[..0], &path[1..]),
        "self" => (module, &path[1..]),
        "super" => (&module[..module.len().checked_sub(supers)?], &path[supers..]),
        _ => (module, path),
    };
    let (first, rest) = rest.split_first()?;
    let here = below(start, first);
    let file = files.get(start)?;
    if files.contains_key(&here) && !rest.is_empty() {
        return defined(files, &here, &[&["self".to_owned()], rest].concat());
    }
    let own = file.items.iter().filter_map(definition).any(|(name, _)| name == *first);
    if own {
        return Some((start.to_vec(), Some(here)));
    }
    let imports =
        file.items.iter().filter_map(|item| if let Item::Use(item) = item { Some(imported(item)) } else { None });
    let import = imports.flatten().find(|(name, _)| name == first);
    match import {
        Some((_, target)) if KNOWN_CRATES.contains(&target[0].as_str()) => Some((vec![target[0].clone()], None)),
        Some((_, target)) => {
            let target = [&target[..], rest].concat();
            let is_local = ["crate", "self", "super"].contains(&target[0].as_str())
                || files.contains_key(&below(start, &target[0]));
            if is_local { defined(files, start, &target) } else { Some((vec![target[0].clone()], None)) }
        }
        // A type that a macro defines.
        None if path[0] == "self" => Some((start.to_vec(), Some(here))),
        None if KNOWN_CRATES.contains(&first.as_str()) && !rest.is_empty() => Some((vec![first.clone()], None)),
        None => None,
    }
}

/// Types in the documented part of one definition that are not documented themselves.
struct Signatures<'a> {
    files: &'a Files,
    module: &'a [String],
    documented: &'a BTreeSet<Names>,
    what: String,
    found: BTreeSet<String>,
}

impl Signatures<'_> {
    fn item(&mut self, item: &Item) {
        match item {
            Item::Const(item) => self.visit_type(&item.ty),
            Item::Enum(item) => item.variants.iter().for_each(|variant| self.visit_variant(variant)),
            Item::Fn(item) => self.visit_signature(&item.sig),
            Item::Struct(item) => item.fields.iter().for_each(|field| self.visit_field(field)),
            Item::Trait(item) => {
                item.supertraits.iter().for_each(|bound| self.visit_type_param_bound(bound));
                item.items.iter().for_each(|item| match item {
                    TraitItem::Fn(item) if !has(&item.attrs, "doc", "hidden") => self.visit_signature(&item.sig),
                    TraitItem::Const(item) => self.visit_type(&item.ty),
                    _ => {}
                });
            }
            Item::Type(item) => self.visit_type(&item.ty),
            _ => {}
        }
    }

    fn methods(&mut self, items: &[ImplItem]) {
        for item in items {
            match item {
                ImplItem::Fn(item) if is_shown(&item.vis, &item.attrs) => self.visit_signature(&item.sig),
                ImplItem::Const(item) if is_shown(&item.vis, &item.attrs) => self.visit_type(&item.ty),
                _ => {}
            }
        }
    }
}

fn is_shown(visibility: &Visibility, attributes: &[Attribute]) -> bool {
    matches!(visibility, Visibility::Public(_)) && !has(attributes, "doc", "hidden")
}

impl<'ast> Visit<'ast> for Signatures<'_> {
    fn visit_signature(&mut self, signature: &'ast syn::Signature) {
        let of_one = format!("{}::{}", self.what, signature.ident);
        let before = std::mem::replace(&mut self.what, of_one);
        visit_signature(self, signature);
        self.what = before;
    }

    fn visit_variant(&mut self, variant: &'ast syn::Variant) {
        if !has(&variant.attrs, "doc", "hidden") {
            let fields = variant.fields.iter().filter(|field| !has(&field.attrs, "doc", "hidden"));
            fields.for_each(|field| self.visit_type(&field.ty));
        }
    }

    fn visit_field(&mut self, field: &'ast syn::Field) {
        if is_shown(&field.vis, &field.attrs) {
            self.visit_type(&field.ty);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Names = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        match defined(self.files, self.module, &names) {
            Some((place, None)) if !KNOWN_CRATES.contains(&place[0].as_str()) => {
                self.found.insert(format!("{}: {} of {}", self.what, names.join("::"), place[0]));
            }
            Some((_, Some(target))) if !self.documented.contains(&target) => {
                self.found.insert(format!("{}: {}", self.what, target.join("::")));
            }
            _ => {}
        }
        visit_path(self, path);
    }
}

/// Returns the documented signatures that contain types without documentation or of other crates.
fn undocumented_types(files: &Files, names: &BTreeSet<Names>) -> BTreeSet<String> {
    let documented: BTreeSet<Names> = names
        .iter()
        .filter_map(|name| {
            let (last, module) = name.split_last()?;
            defined(files, module, &["self".to_owned(), last.clone()])?.1
        })
        .collect();
    let mut found = BTreeSet::new();
    for (module, file) in files {
        let mut signatures =
            Signatures { files, module, documented: &documented, what: String::new(), found: BTreeSet::new() };
        for item in file.items.iter().filter(|item| !has(attributes(item), "cfg", "test")) {
            if let Some((name, _)) = definition(item)
                && documented.contains(&below(module, &name))
            {
                signatures.what = below(module, &name).join("::");
                signatures.item(item);
            }
            if let Item::Impl(item) = item
                && item.trait_.is_none()
                && let Type::Path(of) = &*item.self_ty
            {
                let path: Names = of.path.segments.iter().map(|segment| segment.ident.to_string()).collect();
                if let Some((_, Some(target))) = defined(files, module, &path)
                    && documented.contains(&target)
                {
                    signatures.what = target.join("::");
                    signatures.methods(&item.items);
                }
            }
        }
        found.append(&mut signatures.found);
    }
    found
}

#[test]
fn verif_the_library_has_few_public_names() {
    let (_, [documented, _]) = library();
    for name in [&["Sky"][..], &["passes", "Sky"], &["fit", "measurements", "Measurement"], &["plot", "Picture"]] {
        assert!(documented.contains(&names(name)), "{name:?} is not found");
    }
    let mut by_module = BTreeMap::<&str, usize>::new();
    for name in &documented {
        *by_module.entry(if name.len() == 1 { "root" } else { &name[0] }).or_default() += 1;
    }
    assert!(documented.len() <= MOST_NAMES, "{} public names: {by_module:?}", documented.len());
}

#[test]
fn verif_documented_signatures_have_only_documented_types() {
    let (files, [documented, _]) = library();
    let found: Vec<String> = undocumented_types(&files, &documented).into_iter().collect();
    assert!(found.is_empty(), "{} types are not documented:\n{}", found.len(), found.join("\n"));
}

/// Returns the documented definitions without `#[non_exhaustive]` that `is_open` selects.
fn complete(is_open: impl Fn(&Item) -> bool) -> Vec<String> {
    let (files, [documented, _]) = library();
    let mut complete = BTreeSet::new();
    for name in &documented {
        let Some((last, module)) = name.split_last() else { continue };
        let Some((place, Some(_))) = defined(&files, module, &["self".to_owned(), last.clone()]) else { continue };
        let is_complete = |item: &&Item| {
            definition(item).is_some_and(|(name, _)| name == *last)
                && is_open(item)
                && !attributes(item).iter().any(|attribute| attribute.path().is_ident("non_exhaustive"))
        };
        complete.extend(files[&place].items.iter().filter(is_complete).map(|_| last.clone()));
    }
    complete.into_iter().collect()
}

#[test]
fn verif_documented_enums_may_grow() {
    let found = complete(|item| matches!(item, Item::Enum(_)));
    assert_eq!(found, COMPLETE_ENUMS, "enums without #[non_exhaustive]");
}

#[test]
fn verif_documented_structs_may_grow() {
    let has_only_public_fields = |item: &Item| match item {
        Item::Struct(item) => {
            !item.fields.is_empty() && item.fields.iter().all(|field| matches!(field.vis, Visibility::Public(_)))
        }
        _ => false,
    };
    let found = complete(has_only_public_fields);
    assert_eq!(found, COMPLETE_STRUCTS, "structs without #[non_exhaustive]");
}

#[test]
fn verif_each_documented_module_begins_with_an_example() {
    let (files, [documented, _]) = library();
    let modules: BTreeSet<&[String]> = documented.iter().map(|name| &name[..name.len() - 1]).collect();
    let has_example = |module: &&[String]| {
        files[*module].attrs.iter().any(|attribute| match &attribute.meta {
            syn::Meta::NameValue(doc) => matches!(
                &doc.value,
                syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(line), .. }) if line.value().trim() == "```"
            ),
            _ => false,
        })
    };
    let without: Vec<_> = modules.into_iter().filter(|module| !has_example(module)).collect();
    assert!(without.is_empty(), "modules without an example: {without:?}");
}

#[test]
fn verif_examples_use_only_documented_names() {
    let (_, [documented, _]) = library();
    let (mut examples, mut found) = (0, Vec::new());
    for entry in fs::read_dir(root().join("examples")).expect("examples") {
        let path = entry.expect("an example").path();
        if path.extension().is_none_or(|extension| extension != "rs") {
            continue;
        }
        examples += 1;
        let file = syn::parse_file(&fs::read_to_string(&path).expect("an example")).expect("Rust code");
        for item in &file.items {
            let Item::Use(item) = item else { continue };
            for (_, names) in imported(item).into_iter().filter(|(_, names)| names[0] == "streakcast") {
                if !documented.contains(&names[1..]) {
                    found.push(format!("{}: {}", path.display(), names.join("::")));
                }
            }
        }
    }
    assert!(examples > 5, "only {examples} examples found");
    assert!(found.is_empty(), "names that are not documented:\n{}", found.join("\n"));
}

#[test]
fn verif_a_type_without_documentation_is_found() {
    let file = |text: &str| syn::parse_file(text).expect("Rust code");
    let files = |text: &str| {
        Files::from([
            (names(&[]), file("pub mod a; mod b;")),
            (names(&["a"]), file("mod c; pub use c::{C, f}; #[doc(hidden)] pub use c::{D};")),
            (names(&["a", "c"]), file(&format!("use crate::b::B; use nalgebra::Vector3; pub struct D; {text}"))),
            (names(&["b"]), file("pub struct B;")),
        ])
    };
    let found = |text: &str| {
        let files = files(text);
        let mut names = Default::default();
        public_names(&files, &[], false, &mut names);
        undocumented_types(&files, &names[0])
    };
    for text in [
        "pub fn f(b: &B) {}",
        "pub fn f() -> Option<D> {}",
        "pub struct C { pub b: Vec<B> }",
        "pub enum C { One(D) }",
        "pub struct C; impl C { pub fn b(&self) -> [B; 3] {} }",
        "pub struct C; impl C { pub fn v(&self) -> Vector3<f64> {} }",
        "pub trait C { fn b(&self) -> crate::b::B; }",
    ] {
        assert_eq!(found(text).len(), 1, "{text}");
    }
    for text in [
        "fn g(b: &B) {}",
        "pub fn f(c: Option<&str>) -> f64 {}",
        "pub struct C { b: Vec<B>, #[doc(hidden)] pub d: D }",
        "pub enum C { One, #[doc(hidden)] Two(D) }",
        "pub struct C; impl C { #[doc(hidden)] pub fn b(&self) -> B {} fn v(&self) -> Vector3<f64> {} }",
        "pub struct C; pub fn f<B2: Copy>(b: B2) -> C {}",
    ] {
        assert_eq!(found(text).len(), 0, "{text}: {:?}", found(text));
    }
}

#[test]
fn verif_hidden_and_private_names_are_not_counted() {
    let file = |text: &str| syn::parse_file(text).expect("Rust code");
    let files = Files::from([
        (names(&[]), file("#[doc(hidden)] pub mod a; pub mod b; mod c; pub use c::{self, D, e::F as G};")),
        (names(&["a"]), file("pub struct A;")),
        (
            names(&["b"]),
            file("#[doc(hidden)] pub use crate::c::{H}; pub(crate) use crate::c::I; pub fn j() {} fn k() {}"),
        ),
        (names(&["c"]), file("pub struct D; pub struct H; pub struct I;")),
    ]);
    let mut found: [BTreeSet<Names>; 2] = Default::default();
    public_names(&files, &[], false, &mut found);
    let texts = found.map(|names| names.iter().map(|name| name.join("::")).collect::<Vec<_>>().join(" "));
    assert_eq!(texts, ["D G b::j c", "a::A b::H"]);
}
