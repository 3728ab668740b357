//! Checks of single values of a model file, whose findings are collected.

use crate::Issue;
use crate::model::Model;

/// Largest positive quantity, and the inverse of the smallest one: three of them may be multiplied.
const LARGEST: f64 = 1e100;

/// Mistakes found so far.
#[derive(Default)]
pub(super) struct Checker {
    pub(super) issues: Vec<Issue>,
}

impl Checker {
    pub(super) fn add(
        &mut self,
        place: impl Into<String>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.issues.push(Issue::new(place, message, help));
    }

    pub(super) fn positive(&mut self, key: &str, what: &str, value: f64) {
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

    pub(super) fn not_negative(&mut self, key: &str, what: &str, value: f64) {
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

    pub(super) fn finite(&mut self, key: &str, what: &str, values: &[f64]) {
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

    pub(super) fn missing<'a>(
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

    pub(super) fn amplitude(&mut self, model: &Model, key: &str, name: &Option<String>) {
        if let Some(name) = name
            && !model.amplitudes.contains_key(name)
        {
            self.missing(format!("{key}.amplitude"), "amplitude", name, model.amplitudes.keys());
        }
    }
}
