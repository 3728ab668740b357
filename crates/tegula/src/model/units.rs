//! Names of units for the labels of pictures.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Names of the units of the model, such as `length = "mm"`: for the labels of pictures. Numbers do not change.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Units {
    /// Unit of length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<String>,
    /// Unit of time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// Unit of force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<String>,
    /// Unit of stress; that of force over the square of that of length unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stress: Option<String>,
    /// Unit of energy; that of force times that of length unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<String>,
    /// Unit of frequency; one over that of time unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency: Option<String>,
}

impl Units {
    /// Every name with its key.
    pub fn named(&self) -> impl Iterator<Item = (&'static str, &str)> {
        [
            ("length", &self.length),
            ("time", &self.time),
            ("force", &self.force),
            ("stress", &self.stress),
            ("energy", &self.energy),
            ("frequency", &self.frequency),
        ]
        .into_iter()
        .filter_map(|(key, name)| Some((key, name.as_deref()?)))
    }

    /// Name of the unit of stress.
    pub fn of_stress(&self) -> Option<String> {
        self.stress.clone().or_else(|| Some(format!("{}/{}²", self.force.as_ref()?, self.length.as_ref()?)))
    }

    /// Name of the unit of energy.
    pub fn of_energy(&self) -> Option<String> {
        self.energy.clone().or_else(|| Some(format!("{}·{}", self.force.as_ref()?, self.length.as_ref()?)))
    }

    /// Name of the unit of frequency.
    pub fn of_frequency(&self) -> Option<String> {
        self.frequency.clone().or_else(|| Some(format!("1/{}", self.time.as_ref()?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_that_are_not_named_follow_from_the_others() {
        let name = |text: &str| Some(text.to_owned());
        let mut units = Units { length: name("mm"), force: name("N"), time: name("s"), ..Units::default() };
        assert_eq!(units.of_stress(), name("N/mm²"));
        assert_eq!((units.of_energy(), units.of_frequency()), (name("N·mm"), name("1/s")));
        units.stress = name("MPa");
        assert_eq!(units.of_stress(), name("MPa"));
        assert_eq!(Units::default().of_energy(), None);
    }
}
