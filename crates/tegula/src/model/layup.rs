//! Stacking of laminates as the user says it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Plies of a laminate, from the bottom to the top; the director points to the top.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Layup {
    /// Plies one by one; instead of `stacking`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub plies: Vec<Ply>,
    /// Stacking in short form such as `"[0/90/±45]2s"`: angles in degrees, `_2` repeats a ply, `(…)2` a group, the final
    /// number the whole, `s` mirrors it. Needs `material` and `ply_thickness`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stacking: Option<String>,
    /// Material of the plies of `stacking`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Thickness of a ply of `stacking` (length).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ply_thickness: Option<f64>,
    /// Repeats `plies` so many times.
    #[serde(default = "one")]
    pub repeat: u32,
    /// Mirrors `plies` (after repeating them) at the top.
    #[serde(default)]
    pub symmetric: bool,
    /// Direction of 0°; its projection on the surface is taken.
    #[serde(default = "super::x_axis")]
    pub direction: [f64; 3],
}

/// A ply.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ply {
    /// Name of a material.
    pub material: String,
    /// Angle of the material's axis 1 from `direction`, about the director (degrees).
    #[serde(default)]
    pub angle: f64,
    /// Thickness (length), above 0.
    pub thickness: f64,
}

fn one() -> u32 {
    1
}

/// Plies of any layup; more are hardly meant.
const MOST_PLIES: usize = 1000;

impl Layup {
    /// All plies from the bottom to the top.
    ///
    /// # Errors
    /// What is wrong, and what to do.
    pub fn expand(&self) -> Result<Vec<Ply>, (String, String)> {
        let wrong = |what: &str, help: &str| Err((what.to_owned(), help.to_owned()));
        let mut plies = match (&self.stacking, self.plies.is_empty()) {
            (None, true) => return wrong("the layup has no plies", "give `plies`, or `stacking`"),
            (Some(_), false) => {
                return wrong("the layup has both `plies` and `stacking`", "give one of them");
            }
            (None, false) => self.plies.clone(),
            (Some(text), true) => {
                let (Some(material), Some(thickness)) = (&self.material, self.ply_thickness) else {
                    return wrong(
                        "`stacking` needs `material` and `ply_thickness`",
                        "add them to the layup, or list `plies`",
                    );
                };
                let ply = |angle| Ply { material: material.clone(), angle, thickness };
                angles(text)?.into_iter().map(ply).collect()
            }
        };
        if plies.len().saturating_mul(self.repeat as usize) > MOST_PLIES {
            return wrong("the layup has more than 1000 plies", "join plies of the same angle");
        }
        plies = (0..self.repeat).flat_map(|_| plies.clone()).collect();
        if plies.is_empty() {
            return wrong("`repeat` is 0: the layup has no plies", "give at least 1");
        }
        if self.symmetric {
            plies.extend(plies.clone().into_iter().rev());
        }
        Ok(plies)
    }
}

/// Angles of a stacking in short form.
///
/// # Errors
/// What is wrong, and what to do.
pub fn angles(text: &str) -> Result<Vec<f64>, (String, String)> {
    let mut reader = Reader { rest: text.trim() };
    let result = reader.whole();
    result.map_err(|what| {
        let at = text.trim().len() - reader.rest.len();
        (
            format!("the stacking \"{text}\" is not understood: {what} at position {}", at + 1),
            "write angles between brackets, such as [0/90]s, [0_2/±45]2s or [(0/90)3/45]".into(),
        )
    })
}

struct Reader<'a> {
    rest: &'a str,
}

impl Reader<'_> {
    fn eat(&mut self, c: char) -> bool {
        self.rest = self.rest.trim_start();
        if let Some(rest) = self.rest.strip_prefix(c) {
            self.rest = rest;
            return true;
        }
        false
    }

    fn whole(&mut self) -> Result<Vec<f64>, &'static str> {
        if !self.eat('[') {
            return Err("`[` is missing");
        }
        let mut plies = self.list(']')?;
        let repeat = self.count()?;
        plies = repeated(&plies, repeat)?;
        if self.eat('s') || self.eat('S') {
            plies.extend(plies.clone().into_iter().rev());
        }
        if !self.rest.trim().is_empty() {
            return Err("there is more than expected");
        }
        Ok(plies)
    }

    fn list(&mut self, end: char) -> Result<Vec<f64>, &'static str> {
        let mut out = Vec::new();
        loop {
            let item = if self.eat('(') {
                self.list(')')?
            } else if self.eat('±') {
                let angle = self.angle()?;
                vec![angle, -angle]
            } else if self.eat('∓') {
                let angle = self.angle()?;
                vec![-angle, angle]
            } else {
                vec![self.angle()?]
            };
            // A group takes its number directly, a ply after `_`, which keeps it apart from the angle.
            let group = item.len() > 1;
            let repeat = if self.eat('_') || group { self.count()? } else { 1 };
            out.extend(repeated(&item, repeat)?);
            if self.eat(end) {
                return Ok(out);
            }
            if !(self.eat('/') || self.eat(',')) {
                return Err(if end == ']' { "`/` or `]` is missing" } else { "`/` or `)` is missing" });
            }
        }
    }

    fn angle(&mut self) -> Result<f64, &'static str> {
        self.rest = self.rest.trim_start();
        let end =
            self.rest.find(|c: char| !(c.is_ascii_digit() || "+-.".contains(c))).unwrap_or(self.rest.len());
        let value: f64 = self.rest[..end].parse().map_err(|_| "an angle is missing")?;
        self.rest = &self.rest[end..];
        self.eat('°');
        Ok(value)
    }

    /// A number of repetitions, 1 where there is none.
    fn count(&mut self) -> Result<usize, &'static str> {
        self.rest = self.rest.trim_start();
        let end = self.rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(self.rest.len());
        if end == 0 {
            return Ok(1);
        }
        let value: usize = self.rest[..end].parse().map_err(|_| "the number of repetitions is too large")?;
        if value == 0 {
            return Err("0 repetitions are none");
        }
        self.rest = &self.rest[end..];
        Ok(value)
    }
}

fn repeated(item: &[f64], times: usize) -> Result<Vec<f64>, &'static str> {
    if item.len().saturating_mul(times) > MOST_PLIES {
        return Err("there are more than 1000 plies");
    }
    Ok(item.repeat(times))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn short_forms_are_expanded() {
        for (text, expected) in [
            ("[0/90]", &[0.0, 90.0][..]),
            ("[0/90]s", &[0.0, 90.0, 90.0, 0.0]),
            ("[0_2/90]", &[0.0, 0.0, 90.0]),
            ("[±45/0]", &[45.0, -45.0, 0.0]),
            ("[(0/90)2/45]", &[0.0, 90.0, 0.0, 90.0, 45.0]),
            ("[30]2s", &[30.0, 30.0, 30.0, 30.0]),
            (" [ -20 / +20.5° ] ", &[-20.0, 20.5]),
            ("[±45_2]", &[45.0, -45.0, 45.0, -45.0]),
        ] {
            assert_eq!(angles(text).unwrap(), expected, "{text}");
        }
    }

    #[test]
    fn wrong_forms_say_where() {
        for (text, what) in [
            ("0/90", "`[` is missing at position 1"),
            ("[0/90", "`/` or `]` is missing at position 6"),
            ("[0//90]", "an angle is missing at position 4"),
            ("[(0/90]", "`/` or `)` is missing at position 7"),
            ("[0]x", "there is more than expected at position 4"),
            ("[0_0]", "0 repetitions are none at position 4"),
            ("[0]999999999", "there are more than 1000 plies"),
        ] {
            let message = angles(text).unwrap_err().0;
            assert!(message.contains(what), "{message}");
        }
    }
}
