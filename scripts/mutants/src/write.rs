//! A file with all its mutants.
//!
//! Operands are evaluated once, `a - b` becomes
//!
//! ```text
//! (match (a, b) { (l__, r__) => if ::mutant::is(17) { l__ + r__ } else { l__ - r__ } })
//! ```
//!
//! so that nested mutants do not multiply the text. Every function is written twice: one number compared at its begin leads to
//! its mutants, or else to the original text, which runs at full speed.

use std::collections::{BTreeMap, BTreeSet};

use crate::sites::{Bytes, Parts, Site};

/// Bytes of the written file that belong to a mutant.
#[derive(Debug, Clone, Default)]
pub struct Places {
    /// The expression with all its choices.
    pub site: Vec<[usize; 2]>,
    /// Text of this mutant alone.
    pub branches: Vec<[usize; 2]>,
    /// Function.
    pub body: Vec<[usize; 2]>,
}

/// A written file.
#[derive(Debug, Default)]
pub struct Written {
    pub text: String,
    pub places: BTreeMap<u32, Places>,
}

pub struct Writer<'a> {
    text: &'a str,
    sites: &'a [Site],
    dropped: &'a BTreeSet<u32>,
    out: Written,
}

impl<'a> Writer<'a> {
    pub fn new(text: &'a str, sites: &'a [Site], dropped: &'a BTreeSet<u32>) -> Self {
        Self { text, sites, dropped, out: Written::default() }
    }

    pub fn file(mut self) -> Written {
        self.range(0..self.text.len(), None);
        self.out
    }

    fn push(&mut self, text: &str) {
        self.out.text.push_str(text);
    }

    /// Writes a range of the file, with the sites in it but the one given.
    fn range(&mut self, range: Bytes, without: Option<usize>) {
        let mut at = range.start;
        let sites = self.sites;
        let mut inside: Vec<usize> = (0..sites.len())
            .filter(|&i| {
                Some(i) != without && sites[i].range.start >= range.start && sites[i].range.end <= range.end
            })
            .collect();
        // Outer sites first.
        inside.sort_by_key(|&i| (sites[i].range.start, std::cmp::Reverse(sites[i].range.end)));
        for i in inside {
            let site = &sites[i];
            if site.range.start >= at {
                self.push(&self.text[at..site.range.start]);
                self.site(i);
                at = site.range.end;
            }
        }
        self.push(&self.text[at..range.end]);
    }

    /// Writes `if ::mutant::is(n) { … } else …` for the mutants of a site, each with its text.
    fn choices(&mut self, choices: &[(u32, String)], text: impl Fn(&mut Self, &str)) {
        for (number, choice) in choices {
            self.push(&format!("if ::mutant::is({number}) {{ "));
            let start = self.out.text.len();
            text(self, choice);
            let end = self.out.text.len();
            self.out.places.entry(*number).or_default().branches.push([start, end]);
            self.push(" } else ");
        }
    }

    fn site(&mut self, index: usize) {
        let site = &self.sites[index];
        let choices: Vec<(u32, String)> =
            site.choices.iter().filter(|(n, _)| !self.dropped.contains(n)).cloned().collect();
        if let Parts::Body { last, twice } = site.parts {
            return self.body(index, &choices, last, twice);
        }
        if choices.is_empty() {
            return self.range(site.range.clone(), Some(index));
        }
        let start = self.out.text.len();
        match &site.parts {
            Parts::Binary { left, operator, right } | Parts::Comparison { left, operator, right } => {
                let borrowed = matches!(site.parts, Parts::Comparison { .. });
                let (open, close) = if borrowed { ("&(", ")") } else { ("", "") };
                self.push(&format!("(match ({open}"));
                self.range(left.clone(), None);
                self.push(&format!("{close}, {open}"));
                self.range(right.clone(), None);
                self.push(&format!("{close}) {{ (l__, r__) => "));
                self.choices(&choices, |w, other| w.push(&format!("l__ {other} r__")));
                self.push(&format!("{{ l__ {operator} r__ }} }})"));
            }
            Parts::Logical { left, operator, right } => {
                // De Morgan: !(!a && !b) is a || b.
                self.push(&format!("({{ let m__ = ::mutant::is({}); (((", choices[0].0));
                self.range(left.clone(), None);
                self.push(&format!(") ^ m__) {operator} (("));
                self.range(right.clone(), None);
                self.push(") ^ m__)) ^ m__ })");
            }
            Parts::Assignment { left, operator, right } => {
                let place = &self.text[left.clone()];
                self.push("(match ");
                self.range(right.clone(), None);
                self.push(" { r__ => ");
                self.choices(&choices, |w, other| w.push(&format!("{place} {other} r__")));
                self.push("{ ");
                self.range(left.clone(), None);
                self.push(&format!(" {operator} r__ }} }})"));
            }
            Parts::Unary { operator, value } => {
                self.push("(match (");
                self.range(value.clone(), None);
                self.push(") { e__ => ");
                self.choices(&choices, |w, _| w.push("e__"));
                self.push(&format!("{{ {operator}e__ }} }})"));
            }
            Parts::Register { receiver, method, arguments } => {
                let names = if arguments.len() == 3 { "l__, r__, s__" } else { "l__, r__" };
                self.push("(match (");
                for argument in arguments {
                    self.range(argument.clone(), None);
                    self.push(", ");
                }
                self.push(&format!(") {{ ({names}) => "));
                self.choices(&choices, |w, other| w.push(other));
                self.push(&format!("{{ {receiver}.{method}({names}) }} }})"));
            }
            Parts::Body { .. } => {}
        }
        let end = self.out.text.len();
        for (number, _) in choices {
            self.out.places.entry(number).or_default().site.push([start, end]);
        }
    }

    fn body(&mut self, index: usize, choices: &[(u32, String)], last: u32, twice: bool) {
        let site = &self.sites[index];
        let inside = site.range.start + 1..site.range.end - 1;
        let kept: Vec<u32> = (site.first..=last).filter(|n| !self.dropped.contains(n)).collect();
        if kept.is_empty() {
            self.push(&self.text[site.range.clone()]);
            return;
        }
        let start = self.out.text.len();
        self.push("{ ");
        if twice {
            self.push(&format!("if ::mutant::within({}, {last}) {{ ", site.first));
        }
        for (number, value) in choices {
            let start = self.out.text.len();
            self.push(&format!("if ::mutant::is({number}) {{ return {value}; }} "));
            let end = self.out.text.len();
            let places = self.out.places.entry(*number).or_default();
            places.branches.push([start, end]);
            places.site.push([start, end]);
        }
        self.range(inside.clone(), None);
        if twice {
            self.push("} else {");
            self.push(&self.text[inside]);
            self.push("}");
        }
        self.push("}");
        let end = self.out.text.len();
        for number in kept {
            self.out.places.entry(number).or_default().body.push([start, end]);
        }
    }
}
