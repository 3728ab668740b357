//! TOML text under construction, each line with the line of the input file that it comes from.

/// Text of a model file made of an input file.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Document {
    /// The text.
    pub text: String,
    /// Line of the input file for each line of the text, counted from 1; 0 for none.
    pub lines: Vec<usize>,
}

impl Document {
    /// Adds a line that comes from the line `origin` of the input file.
    pub fn line(&mut self, origin: usize, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
        self.lines.push(origin);
    }

    /// Adds a key with its value in TOML.
    pub fn key(&mut self, origin: usize, key: &str, value: &str) {
        self.line(origin, &format!("{key} = {value}"));
    }

    /// Adds an empty line and the head of a table, with a comment that names the `card`, as it is spelt in the file.
    pub fn table(&mut self, origin: usize, head: &str, card: &str) {
        self.line(origin, "");
        self.line(origin, &format!("{head}  # line {origin}: {card}"));
    }
}

/// A TOML string; control characters become blanks.
pub(crate) fn quoted(text: &str) -> String {
    let plain: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    serde_json::Value::String(plain).to_string()
}

/// A TOML key: bare where it may be, else a string.
pub(crate) fn bare(key: &str) -> String {
    let plain = !key.is_empty() && key.bytes().all(|b| b.is_ascii_alphanumeric() || b"_-".contains(&b));
    if plain { key.to_owned() } else { quoted(key) }
}

/// A TOML number.
pub(crate) fn number(x: f64) -> String {
    // No negative zero, which a changed sign makes of 0.
    format!("{:?}", x + 0.0)
}

/// A TOML list of numbers.
pub(crate) fn vector(x: &[f64]) -> String {
    format!("[{}]", x.iter().map(|&x| number(x)).collect::<Vec<_>>().join(", "))
}

/// A TOML list of the axes whose flags are set.
pub(crate) fn axes(of: [bool; 3]) -> String {
    let names = ["\"x\"", "\"y\"", "\"z\""];
    let set: Vec<&str> = names.into_iter().zip(of).filter(|(_, set)| *set).map(|(name, _)| name).collect();
    format!("[{}]", set.join(", "))
}
