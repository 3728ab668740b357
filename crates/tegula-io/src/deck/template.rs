//! Templates of model files; each one runs unchanged.

/// Kinds of templates, for `tegula new KIND`.
pub fn template_kinds() -> &'static [&'static str] {
    &["static", "modal", "transient", "gmsh"]
}

/// The commented model file of a kind, complete and ready to run.
pub fn template(kind: &str) -> Option<&'static str> {
    match kind {
        "static" => Some(include_str!("../../templates/static.toml")),
        "modal" => Some(include_str!("../../templates/modal.toml")),
        "transient" => Some(include_str!("../../templates/transient.toml")),
        "gmsh" => Some(include_str!("../../templates/gmsh.toml")),
        _ => None,
    }
}

/// Further files that the template of a kind requires: names and contents.
pub fn template_companions(kind: &str) -> &'static [(&'static str, &'static str)] {
    match kind {
        "gmsh" => &[
            ("plate.geo", include_str!("../../templates/plate.geo")),
            ("plate.msh", include_str!("../../templates/plate.msh")),
        ],
        _ => &[],
    }
}

/// The template of a kind for a model called `stem`, and its companions by names made from it, so that several
/// templates can lie in one folder: text of the model, with the line by which editors find its schema; names and contents
/// of the other files.
pub fn template_named(kind: &str, stem: &str) -> Option<(String, Vec<(String, String)>)> {
    let companions = template_companions(kind);
    let renamed = |text: &str| {
        companions.iter().fold(text.to_owned(), |text, (name, _)| {
            let (_, ending) = name.rsplit_once('.').unwrap_or((name, ""));
            text.replace(name, &format!("{stem}.{ending}"))
        })
    };
    let files = companions.iter().map(|(name, content)| (renamed(name), renamed(content)));
    Some((super::editor::directive() + &renamed(template(kind)?), files.collect()))
}
