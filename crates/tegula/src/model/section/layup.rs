//! Layups as the model file gives them, and their plies.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Layers;
use super::stacking::{self, MOST_PLIES};
use crate::error::Issue;

/// Plies of a laminate, from the bottom (against the director) to the top: one by one in `plies`, or in the
/// compact notation `stacking` with one material and thickness.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Layup {
    /// The plies from the bottom to the top. Give either these or `stacking`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub plies: Vec<LayupPly>,
    /// Stacking sequence such as `"[0/90/±45]2s"`: angles in degrees from the bottom to the top; `_2` repeats
    /// a ply, `(…)2` a group, the number after `]` all, and `s` mirrors the result. `±` may be written `+-`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stacking: Option<String>,
    /// Name of the material of plies that do not name their own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Thickness of plies that do not give their own (length), above 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub ply_thickness: Option<f64>,
    /// The plies, repeats included, are the lower half; their mirror image lies on top.
    #[serde(default)]
    pub symmetric: bool,
    /// How often the plies follow each other, at least 1.
    #[serde(default = "once")]
    #[schemars(range(min = 1))]
    pub repeat: usize,
    /// Direction of the angle 0° in space, projected on the surface. Angles are counted from it about the
    /// director, counter-clockwise if the director points to the viewer. It must not be normal to the surface.
    #[serde(default = "along_x")]
    #[schemars(extend("x-marker" = "direction"))]
    pub direction: [f64; 3],
    /// Height of the laminate's middle above the mesh, along the director (length).
    #[serde(default)]
    pub offset: f64,
}

/// A ply of a layup.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LayupPly {
    /// Name of a material; that of the layup unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Angle from the 0° direction to the fibre, about the director (degrees).
    #[serde(default)]
    pub angle: f64,
    /// Thickness (length), above 0; `ply_thickness` of the layup unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thickness: Option<f64>,
}

/// A ply of the finished stack.
#[derive(Debug, Clone, PartialEq)]
pub struct StackedPly {
    /// Name of its material.
    pub material: String,
    /// Angle from the 0° direction to the fibre, about the director (degrees).
    pub angle: f64,
    /// Thickness (length).
    pub thickness: f64,
}

fn once() -> usize {
    1
}
fn along_x() -> [f64; 3] {
    [1.0, 0.0, 0.0]
}

impl Default for Layup {
    fn default() -> Self {
        Self {
            plies: Vec::new(),
            stacking: None,
            material: None,
            ply_thickness: None,
            symmetric: false,
            repeat: once(),
            direction: along_x(),
            offset: 0.0,
        }
    }
}

impl Layup {
    /// All plies, bottom to top. `key` is the path of the layup in the model file, for messages.
    ///
    /// # Errors
    ///
    /// Everything wrong with the layup's own values, at its keys. Whether the materials exist is not
    /// looked at.
    pub fn expand(&self, key: &str) -> Result<Vec<StackedPly>, Vec<Issue>> {
        let mut issues = Vec::new();
        if let Some(t) = self.ply_thickness.filter(|t| !positive(*t)) {
            add(
                &mut issues,
                format!("{key}.ply_thickness"),
                format!("the thickness of the plies is {t}; it must be above 0"),
                "give the thickness of one cured ply",
            );
        }
        let Period { plies, repeat, symmetric } = self.period(key, &mut issues);
        // With `stacking` all plies lack the same; one message is enough.
        match self.stacking {
            Some(_) => plies.iter().take(1).for_each(|ply| self.check_ply(ply, key, &mut issues)),
            None => plies.iter().enumerate().for_each(|(i, ply)| {
                self.check_ply(ply, &format!("{key}.plies[{i}]"), &mut issues);
            }),
        }
        let all = plies.len().saturating_mul(repeat).saturating_mul(if symmetric { 2 } else { 1 });
        if repeat == 0 || all > MOST_PLIES {
            add(
                &mut issues,
                format!("{key}.repeat"),
                format!("repeated {repeat} times the layup has {all} plies; it must have 1 to {MOST_PLIES}"),
                "leave `repeat` out to take the plies once",
            );
        }
        self.check_placement(key, &mut issues);
        if !issues.is_empty() {
            return Err(issues);
        }
        let half: Vec<StackedPly> = plies
            .iter()
            .filter_map(|p| {
                Some(StackedPly {
                    material: p.material.clone().or_else(|| self.material.clone())?,
                    angle: p.angle,
                    thickness: p.thickness.or(self.ply_thickness)?,
                })
            })
            .collect();
        let mut stack = vec![half; repeat].concat();
        if symmetric {
            stack.extend(stack.clone().into_iter().rev());
        }
        Ok(stack)
    }

    /// Plies that are repeated, from `plies` or the stacking sequence; none where these cannot be read.
    fn period(&self, key: &str, issues: &mut Vec<Issue>) -> Period {
        let mut period = Period { plies: Vec::new(), repeat: self.repeat, symmetric: self.symmetric };
        match (&self.stacking, self.plies.is_empty()) {
            (None, true) => add(
                issues,
                key.into(),
                "the layup has no plies".into(),
                "list `plies`, or give `stacking` such as \"[0/90]s\" with `material` and `ply_thickness`",
            ),
            (Some(_), false) => add(
                issues,
                format!("{key}.stacking"),
                "the layup has both `stacking` and `plies`".into(),
                "keep one of them",
            ),
            (Some(text), true) => match stacking::parse(text) {
                Err(reason) => add(
                    issues,
                    format!("{key}.stacking"),
                    format!("the stacking sequence \"{text}\" cannot be read: {reason}"),
                    "write it like \"[0/90/±45]2s\", angles in degrees from the bottom to the top",
                ),
                Ok(s) => {
                    if s.symmetric && self.symmetric || s.repeat.is_some() && self.repeat != 1 {
                        add(
                            issues,
                            format!("{key}.stacking"),
                            format!(
                                "\"{text}\" and the keys `symmetric` or `repeat` say the same thing twice"
                            ),
                            "say it in the string or in the keys",
                        );
                    }
                    period.symmetric |= s.symmetric;
                    period.repeat = s.repeat.unwrap_or(self.repeat);
                    let ply = |angle| LayupPly { material: None, angle, thickness: None };
                    period.plies.extend(s.angles.into_iter().map(ply));
                }
            },
            (None, false) => period.plies.clone_from(&self.plies),
        }
        period
    }

    /// Checks the values of a ply, with those of the layup in place of the ones that it does not give.
    fn check_ply(&self, ply: &LayupPly, key: &str, issues: &mut Vec<Issue>) {
        if !ply.angle.is_finite() {
            add(issues, format!("{key}.angle"), "the angle is not a number".into(), "give it in degrees");
        }
        if ply.material.is_none() && self.material.is_none() {
            add(
                issues,
                key.into(),
                "the material is missing".into(),
                "add `material`, the name of a material, to the layup or to each of its plies",
            );
        }
        match ply.thickness {
            Some(t) if !positive(t) => add(
                issues,
                format!("{key}.thickness"),
                format!("the thickness is {t}; it must be above 0"),
                "give the thickness of the cured ply",
            ),
            None if self.ply_thickness.is_none() => add(
                issues,
                key.into(),
                "the thickness is missing".into(),
                "add `ply_thickness` to the layup or `thickness` to each of its plies",
            ),
            _ => {}
        }
    }

    /// Checks the direction of 0° and the offset from the mesh.
    fn check_placement(&self, key: &str, issues: &mut Vec<Issue>) {
        let d = self.direction;
        if !d.iter().map(|x| x * x).sum::<f64>().is_normal() {
            add(
                issues,
                format!("{key}.direction"),
                "the direction of 0° must be a vector with a length".into(),
                "give it like [1, 0, 0]; its length does not matter",
            );
        }
        if !self.offset.is_finite() {
            add(issues, format!("{key}.offset"), "the offset is not a number".into(), "leave it out for 0");
        }
    }
}

/// Plies of a layup without their repeats and mirror image.
struct Period {
    plies: Vec<LayupPly>,
    repeat: usize,
    symmetric: bool,
}

fn add(issues: &mut Vec<Issue>, at: String, message: String, help: &str) {
    issues.push(Issue::new(at, message, help.to_string()));
}

impl Layers for Layup {
    fn plies(&self, key: &str) -> Result<Vec<StackedPly>, Vec<Issue>> {
        self.expand(key)
    }

    fn direction(&self) -> [f64; 3] {
        self.direction
    }

    fn offset(&self) -> f64 {
        self.offset
    }

    fn example(material: &str) -> Self {
        Self {
            stacking: Some("[0/±45/90]s".into()),
            material: Some(material.into()),
            ply_thickness: Some(0.01),
            ..Self::default()
        }
    }
}

fn positive(x: f64) -> bool {
    x.is_finite() && x > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(json: &str) -> Layup {
        serde_json::from_str(json).unwrap()
    }

    fn stack(json: &str) -> Vec<(String, f64, f64)> {
        let plies = read(json).expand("layup").unwrap();
        plies.into_iter().map(|p| (p.material, p.angle, p.thickness)).collect()
    }

    fn issues(json: &str) -> Vec<String> {
        read(json).expand("sections[0].layup").unwrap_err().iter().map(|i| i.place.key.clone()).collect()
    }

    #[test]
    fn plies_repeat_first_and_mirror_then() {
        let found = stack(
            r#"{"plies": [{"material": "cfrp", "angle": 45.0, "thickness": 1.25e-4},
                          {"material": "foam", "thickness": 0.01}], "symmetric": true, "repeat": 2}"#,
        );
        let a = ("cfrp".to_string(), 45.0, 1.25e-4);
        let b = ("foam".to_string(), 0.0, 0.01);
        let half = [a.clone(), b.clone(), a.clone(), b.clone()];
        assert_eq!(found[..4], half);
        assert_eq!(found[4..], [b.clone(), a.clone(), b, a]);
    }

    #[test]
    fn a_string_and_keys_say_the_same() {
        let short = stack(r#"{"stacking": "[0/±45]2s", "material": "c", "ply_thickness": 0.1}"#);
        let keys = stack(
            r#"{"stacking": "[0/45/-45]", "material": "c", "ply_thickness": 0.1, "repeat": 2,
                "symmetric": true}"#,
        );
        let list = stack(
            r#"{"plies": [{}, {"angle": 45}, {"angle": -45}], "material": "c", "ply_thickness": 0.1,
                "repeat": 2, "symmetric": true}"#,
        );
        assert_eq!(short.len(), 12);
        assert_eq!(short, keys);
        assert_eq!(short, list);
        let angles: Vec<f64> = short.iter().map(|p| p.1).collect();
        assert_eq!(angles, [0., 45., -45., 0., 45., -45., -45., 45., 0., -45., 45., 0.]);
    }

    #[test]
    fn a_ply_overrides_the_layup() {
        let found = stack(
            r#"{"plies": [{"angle": 30}, {"material": "core", "thickness": 5}], "material": "c",
                "ply_thickness": 0.1}"#,
        );
        assert_eq!(found, [("c".to_string(), 30.0, 0.1), ("core".to_string(), 0.0, 5.0)]);
    }

    #[test]
    fn all_mistakes_are_found_at_once() {
        let place = |s: &str| format!("sections[0].layup{s}");
        assert_eq!(issues("{}"), [place("")]);
        assert_eq!(
            issues(
                r#"{"plies": [{"material": "c", "thickness": -1}, {"thickness": 1}, {"material": "c"}],
                    "direction": [0, 0, 0], "repeat": 0}"#
            ),
            [
                place(".plies[0].thickness"),
                place(".plies[1]"),
                place(".plies[2]"),
                place(".repeat"),
                place(".direction")
            ]
        );
        assert_eq!(
            issues(r#"{"stacking": "[0/90]s", "ply_thickness": 0}"#),
            [place(".ply_thickness"), place("")]
        );
        assert_eq!(
            issues(r#"{"stacking": "[0/90]s", "symmetric": true, "material": "c", "ply_thickness": 1}"#),
            [place(".stacking")]
        );
        assert_eq!(
            issues(r#"{"stacking": "[0/90", "plies": [], "material": "c", "ply_thickness": 1}"#),
            [place(".stacking")]
        );
        assert_eq!(
            issues(r#"{"stacking": "[0_9000]s", "material": "c", "ply_thickness": 1}"#),
            [place(".repeat")]
        );
        let unknown = serde_json::from_str::<Layup>(r#"{"stack": "[0]"}"#);
        assert!(unknown.unwrap_err().to_string().contains("unknown field"));
    }

    #[test]
    fn it_is_written_as_it_is_read() {
        let layup = read(r#"{"stacking": "[0/90]s", "material": "c", "ply_thickness": 0.25}"#);
        assert_eq!(layup.direction, [1.0, 0.0, 0.0]);
        let text = serde_json::to_string(&layup).unwrap();
        assert_eq!(read(&text), layup);
    }
}
