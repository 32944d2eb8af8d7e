//! Public names of the library: their number, and the types in their signatures.
//!
//! A public name is a type, trait, function, constant or macro with a documented path: all modules of the path and the
//! name itself are `pub` without `#[doc(hidden)]`. A name with two such paths counts twice; names of optional features
//! count; modules, methods, fields and variants do not.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use syn::{Attribute, Item, ItemUse, UseTree, Visibility};

/// Most public names.
const MOST_NAMES: usize = 250;

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
        UseTree::Glob(_) => panic!("glob import in {path:?}: names cannot be counted"),
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
