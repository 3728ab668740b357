//! Warning of commands and cards that no analysis uses.

use std::collections::BTreeSet;

use tegula::Issue;

use super::case_control::{Control, Solution, full};
use super::loads::LoadSets;
use crate::conversion::listed;
use crate::mesh::nastran::file::File;
use crate::mesh::nastran::supports;
use crate::mesh::numbered::Reader;

/// Commands that have a role in the subcase at an index.
fn roles(solution: Solution, index: usize) -> &'static [&'static str] {
    match solution {
        Solution::Statics => &["SPC", "LOAD"],
        Solution::Modes => &["SPC", "METHOD"],
        Solution::Buckling if index == 0 => &["SPC", "LOAD"],
        Solution::Buckling => &["SPC", "METHOD", "STATSUB"],
        Solution::Nonlinear(_) => &["SPC", "LOAD", "NLPARM"],
    }
}

/// Command that selects a card; `None` where none does.
fn command(card: &str) -> Option<&'static str> {
    match card {
        "SPC" | "SPC1" | "SPCADD" => Some("SPC"),
        "FORCE" | "MOMENT" | "PLOAD2" | "PLOAD4" | "GRAV" | "LOAD" => Some("LOAD"),
        "EIGRL" | "EIGR" => Some("METHOD"),
        "NLPARM" => Some("NLPARM"),
        _ => None,
    }
}

/// Warning of selections that have no role in the solution sequence or that a later one replaces, and of the cards of sets that no subcase
/// selects.
pub(super) fn warning(
    reader: &Reader<'_>,
    file: &File<'_>,
    control: &Control,
    sets: &LoadSets,
) -> Option<Issue> {
    let mut lines: BTreeSet<usize> = BTreeSet::new();
    let mut used: BTreeSet<(&str, u64)> = BTreeSet::new();
    for (i, subcase) in control.subcases.iter().enumerate() {
        for &role in roles(control.solution.0, i) {
            let Some((number, line)) = subcase.selected(role) else { continue };
            lines.insert(line);
            used.insert((role, number));
            match role {
                "SPC" => {
                    let found = supports::selected(reader, file, number).unwrap_or_default();
                    used.extend(found.into_keys().map(|set| (role, set)));
                }
                "LOAD" => used.extend(sets.combined(number).map(|set| (role, set))),
                _ => {}
            }
        }
    }
    let selects = ["SPC", "LOAD", "METHOD", "NLPARM", "STATSUB"];
    let commands = file
        .case
        .iter()
        .filter_map(|command| Some((full(command)?, command.line)))
        .filter(|(name, line)| selects.contains(name) && !lines.contains(line))
        .map(|(name, line)| (format!("the command {name}"), line));
    let cards = file
        .cards
        .iter()
        .filter(|card| {
            let number = card.field(0).text.parse().ok();
            command(&card.name)
                .is_some_and(|command| !number.is_some_and(|number| used.contains(&(command, number))))
        })
        .map(|card| (card.name.clone(), card.line));
    let all: Vec<(String, usize)> = commands.chain(cards).collect();
    let list = listed("", all.iter().map(|(name, line)| (name.as_str(), *line)));
    let supports = all.iter().any(|(name, _)| command(name) == Some("SPC"));
    let none = if supports && file.support_set().is_none() { "; there is no command SPC" } else { "" };
    (!list.is_empty()).then(|| {
        Issue::new(
            "",
            format!("no analysis uses these parts of the input file: {list}{none}"),
            "select sets in the case control, such as SPC = 1, or remove what is not needed",
        )
    })
}
