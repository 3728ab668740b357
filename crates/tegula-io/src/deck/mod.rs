//! The model file: TOML text in, a [`Model`] out, or everything that is wrong with it at once.
//!
//! | file | is |
//! |---|---|
//! | `schema` | the JSON Schema of [`Model`], and what it expects of a value |
//! | `editor` | the same for editors: one slip gives one message there |
//! | `markers` | named points and axes: coordinates take the place of their names |
//! | `validate` | validation of the syntax tree against the schema |
//! | `scheme_default` | the scheme of time integration where the file gives none |
//! | `partial` | what else is wrong when keys are wrong already |
//! | `unknown` | suggestions for an unknown key |
//! | `syntax` | messages for the errors of the TOML parser |
//! | `keyword_input` | input files of Abaqus, CalculiX and Nastran in the place of model files |
//! | `locate` | from the path of a key to its place in the text, and back |
//! | `template` | model files to begin with |
//!
//! ```
//! use tegula_io::deck::Deck;
//!
//! let text = tegula_io::deck::template("static").unwrap().replace("thickness", "tickness");
//! let errors = Deck::parse("model.toml", text).unwrap_err();
//! assert_eq!(errors[0].message, "unknown key \"tickness\"");
//! assert_eq!(errors[0].help, "did you mean \"thickness\"?");
//! ```

mod diagnostic;
mod editor;
mod keyword_input;
mod locate;
mod markers;
mod partial;
mod schema;
mod scheme_default;
mod syntax;
mod template;
mod unknown;
mod validate;

use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf};

use serde::Deserialize as _;
use tegula::{Issue, Model};
use toml::Spanned;
use toml::de::DeTable;

use diagnostic::Source;
pub use diagnostic::{Diagnostic, MOST_DIAGNOSTICS};
pub use editor::{SCHEMA_FILE, is_schema, schema, schema_text};
pub use keyword_input::KeywordInput;
pub use template::{template, template_companions, template_kinds, template_named};

/// Name that a model from the standard input has in messages and results.
pub const STANDARD_INPUT: &str = "<stdin>";
/// Help of an error that the validator should have found first.
const UNEXPECTED: &str = "compare it with the templates: tegula new static";

/// A model file that has been read: the model and the text it came from.
#[derive(Debug, Clone, PartialEq)]
pub struct Deck {
    /// Model that the file describes.
    pub model: Model,
    /// Path of the file.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
    /// Warnings of the text that the model does not show: markers that nothing uses.
    pub warnings: Vec<Issue>,
    /// Input file of another program that the text was made of; its lines are those of messages.
    pub input: Option<KeywordInput>,
}

impl Deck {
    /// Reads the model file at `path`, or the standard input where it is `-`; on failure everything that is wrong with
    /// it, in the order of the text. Pipes are read once.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Vec<Diagnostic>> {
        let path = path.as_ref();
        let (path, bytes) = if path == Path::new("-") {
            let mut bytes = Vec::new();
            (Path::new(STANDARD_INPUT), std::io::stdin().lock().read_to_end(&mut bytes).map(|_| bytes))
        } else {
            (path, std::fs::read(path))
        };
        let bytes = bytes.map_err(|error| unreadable(path, &error))?;
        if let Some(format) = keyword_input::by_name(path, &bytes) {
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
            return keyword_input::parse(path, &bytes, format, &name);
        }
        match String::from_utf8(bytes) {
            Ok(text) => Self::parse(path, text),
            Err(error) => {
                let valid = error.utf8_error().valid_up_to();
                let text = String::from_utf8_lossy(error.as_bytes());
                Err(vec![Source::new(path, &text).at(
                    valid..valid + 1,
                    "",
                    "the file is not UTF-8 text from here on",
                    "save it with the encoding UTF-8",
                )])
            }
        }
    }

    /// Reads the input file of Abaqus, CalculiX or Nastran at `path`, whatever its name; the model gives the name `mesh_file` to it, and its text
    /// is the model file. On failure everything that is wrong with it.
    pub fn convert(path: &Path, mesh_file: &str) -> Result<Self, Vec<Diagnostic>> {
        let bytes = std::fs::read(path).map_err(|error| unreadable(path, &error))?;
        let format =
            keyword_input::by_name(path, &bytes).unwrap_or_else(|| keyword_input::by_content(&bytes));
        keyword_input::parse(path, &bytes, format, mesh_file)
    }

    /// Reads a model from `text`; `path` appears in errors and is the place that mesh files are relative to.
    pub fn parse(path: impl Into<PathBuf>, text: impl Into<String>) -> Result<Self, Vec<Diagnostic>> {
        let (path, text) = (path.into(), text.into());
        if text.trim_start_matches('\u{feff}').trim().is_empty() {
            return Err(vec![Diagnostic::whole(
                &path,
                "the file is empty",
                "begin with a new model: tegula new static",
            )]);
        }
        let source = Source::new(&path, &text);
        if let Some(place) = text.find('\0') {
            return Err(vec![source.at(
                place..place + 1,
                "",
                "the file holds a zero byte here: it is damaged, or no text",
                "remove the byte, or save the file as plain UTF-8 text",
            )]);
        }
        let (tree, errors) = DeTable::parse_recoverable(&text);
        if !errors.is_empty() {
            let found = syntax::diagnostics(&source, &errors);
            let all = found.len();
            return Err(source.limited(found, all));
        }
        let (model, warnings) = model(&source, &path, tree)?;
        Ok(Self { model, path, text, warnings, input: None })
    }

    /// The issues of the model at their places in the file, the first hundred of them. An issue of a key that the file
    /// leaves at its default is placed at the table that would hold it.
    pub fn locate(&self, issues: &[Issue]) -> Vec<Diagnostic> {
        let source = Source::new(&self.path, &self.text);
        let shown = &issues[..issues.len().min(MOST_DIAGNOSTICS)];
        let found = source.limited(locate_all(&source, shown), issues.len());
        match &self.input {
            Some(input) => input.translated(&self.path, found),
            None => found,
        }
    }

    /// The deck of another model that this one leads to: of a step or a branch.
    pub(crate) fn leading_to(&self, model: Model) -> Self {
        Self { model, warnings: Vec::new(), ..self.clone() }
    }

    /// Path of a file that the model names relative to the model file.
    pub fn beside(&self, file: impl AsRef<Path>) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(file)
    }
}

/// Diagnostic of a file that cannot be read.
fn unreadable(path: &Path, error: &std::io::Error) -> Vec<Diagnostic> {
    let (message, help) = match error.kind() {
        ErrorKind::NotFound => (
            "there is no such file".to_owned(),
            "check the path, or begin with a new model: tegula new static",
        ),
        ErrorKind::IsADirectory => (
            "this is a directory, not a model file".to_owned(),
            "give the path of the model file in it, such as model.toml",
        ),
        _ => (format!("the file cannot be read: {error}"), "check the file and its permissions"),
    };
    vec![Diagnostic::whole(path, message, help)]
}

/// Model of the tree of a text, and warnings.
fn model(
    source: &Source,
    path: &Path,
    tree: Spanned<DeTable<'_>>,
) -> Result<(Model, Vec<Issue>), Vec<Diagnostic>> {
    let markers = markers::Markers::read(source, tree.get_ref());
    // From here on it refers to the coordinates of the markers, too.
    let mut tree = tree;
    let replaced = markers.replace(source, &schema::schema(), tree.get_mut());
    let mut found = validate::validate(source, tree.get_ref());
    found.extend(replaced.found);
    tree.get_mut().remove(markers::KEY);
    if found.is_empty()
        && let Some(key) = replaced.undetermined.first()
    {
        let span = locate::span_of(tree.get_ref(), key);
        found.push(source.at(
            span,
            key.as_str(),
            "the marker has no place",
            "check the marker and what it is on",
        ));
    }
    if !found.is_empty() {
        // Of a file with that many mistakes nothing can be said beyond them.
        if found.len() <= MOST_DIAGNOSTICS {
            let issues = partial::issues(path, tree, &found, replaced.undetermined);
            found.extend(locate_all(source, &issues));
        }
        found.sort_by_key(|d| d.span.start);
        let all = found.len();
        return Err(source.limited(found, all));
    }
    let without_scheme = scheme_default::WithoutScheme::of(tree.get_ref());
    match Model::deserialize(toml::Deserializer::from(tree)) {
        Ok(mut model) => {
            without_scheme.complete(&mut model);
            Ok((model, replaced.unused))
        }
        Err(error) => {
            let span = error.span().unwrap_or_default();
            let (tree, _) = DeTable::parse_recoverable(source.text());
            let key = locate::key_at(tree.get_ref(), span.start);
            Err(vec![source.at(span, key, error.message(), UNEXPECTED)])
        }
    }
}

fn locate_all(source: &Source, issues: &[Issue]) -> Vec<Diagnostic> {
    if issues.is_empty() {
        return Vec::new();
    }
    let (tree, _) = DeTable::parse_recoverable(source.text());
    let place = |issue: &Issue| {
        let span = locate::span_of(tree.get_ref(), &issue.place.key);
        let Issue { place, message, help } = issue;
        source.at(span, place.key.as_str(), message.as_str(), help.as_str())
    };
    issues.iter().map(place).collect()
}

#[cfg(test)]
mod tests;
