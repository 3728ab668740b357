//! Checks of single values of a model file, whose findings are collected, and what its schema says of values.

use crate::Issue;

/// Largest positive quantity, and the inverse of the smallest one: three of them may be multiplied.
const LARGEST: f64 = 1e100;

/// Mistakes found so far, each at its key of the model file.
#[derive(Default)]
pub(crate) struct Checker {
    pub(crate) issues: Vec<Issue>,
}

impl Checker {
    /// Adds a mistake: key, message, help. One that is told already, such as that of another component of a vector, is not repeated.
    pub(crate) fn add(
        &mut self,
        place: impl Into<String>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let issue = Issue::new(place, message, help);
        if !self.issues.contains(&issue) {
            self.issues.push(issue);
        }
    }

    /// Refuses a quantity that is not above 0 or of absurd size.
    pub(crate) fn positive(&mut self, key: &str, what: &str, value: f64) {
        if !(value > 0.0 && value.is_finite()) {
            self.add(
                key,
                format!("{what} is {value}; it must be above 0"),
                "give a positive number in the model's units",
            );
        } else if !(1.0 / LARGEST..=LARGEST).contains(&value) {
            self.add(
                key,
                format!("{what} is {value:e}; products of such numbers cannot be computed"),
                format!("give a number between {:e} and {LARGEST:e}; check the units", 1.0 / LARGEST),
            );
        }
    }

    /// Refuses a quantity below 0 or of absurd size.
    pub(crate) fn not_negative(&mut self, key: &str, what: &str, value: f64) {
        if !(value >= 0.0 && value.is_finite()) {
            self.add(
                key,
                format!("{what} is {value}; it must not be negative"),
                "give 0 or a positive number",
            );
        } else if value != 0.0 {
            self.positive(key, what, value);
        }
    }

    /// Refuses 0 and numbers that are not finite or of absurd size; numbers of both signs are valid.
    pub(crate) fn not_zero(&mut self, key: &str, what: &str, value: f64, help: &str) {
        if value == 0.0 || !value.is_finite() {
            self.add(key, format!("{what} is {value}; it must be finite and not 0"), help);
        } else {
            self.positive(key, what, value.abs());
        }
    }

    /// Refuses numbers that are not finite or of absurd size.
    pub(crate) fn finite(&mut self, key: &str, what: &str, values: &[f64]) {
        if !values.iter().all(|v| v.is_finite()) {
            self.add(key, format!("{what} is not a finite number"), "give finite numbers");
        } else if let Some(large) = values.iter().find(|v| v.abs() > LARGEST) {
            self.add(
                key,
                format!("{what} has the component {large:e}; products of such numbers cannot be computed"),
                format!("give numbers of a size up to {LARGEST:e}; check the units"),
            );
        }
    }

    /// Refuses a name that cannot be a part of file names; true if it can.
    pub(crate) fn file_name(&mut self, key: &str, name: &str, longest: usize) -> bool {
        let known = |ch: char| ch.is_alphanumeric() || "_-. ".contains(ch);
        let fits = !name.is_empty() && name.chars().count() <= longest && name.chars().all(known);
        if !fits {
            self.add(
                key,
                format!("{:?} cannot be a name", name.chars().take(longest).collect::<String>()),
                format!("use up to {longest} letters, digits, blanks, '_', '-' and '.'"),
            );
        }
        fits
    }

    /// Reports a name that the model does not define, with those that it does.
    pub(crate) fn missing<'a>(
        &mut self,
        key: String,
        kind: &str,
        name: &str,
        known: impl Iterator<Item = &'a String>,
    ) {
        const LISTED: usize = 20;
        let known: Vec<&str> = known.map(String::as_str).collect();
        let help = if known.is_empty() {
            format!("the model defines no {kind}; add one")
        } else if known.len() > LISTED {
            format!("known: {} and {} more", known[..LISTED].join(", "), known.len() - LISTED)
        } else {
            format!("known: {}", known.join(", "))
        };
        self.add(key, format!("there is no {kind} \"{name}\""), help);
    }
}

/// True for 0: such a value is left out of a written model file.
pub(crate) fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Says in the schema of a list that its entries are above 0.
pub(crate) fn positive_entries(schema: &mut schemars::Schema) {
    if let Some(entries) = schema.get_mut("items").and_then(|items| items.as_object_mut()) {
        entries.insert("exclusiveMinimum".into(), 0.into());
    }
}
