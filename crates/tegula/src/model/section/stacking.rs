//! The compact notation of stacking sequences: `[0/90/±45]2s`.
//!
//! ```text
//! laminate = "[" plies "]" [ "_" ] [ count ] [ "s" ]
//! plies    = group { "/" group }
//! group    = angle [ "_" count ]  |  "(" plies ")" [ [ "_" ] count ]
//! angle    = [ "+" | "-" | "±" | "∓" | "+-" | "-+" ] number [ "°" ]
//! ```

/// Largest number of plies of a stacking sequence; more are most likely a mistake.
pub(super) const MOST_PLIES: usize = 10_000;

/// Most brackets within brackets.
const DEEPEST: usize = 16;

/// A stacking sequence as it is written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stacking {
    /// Angles between the brackets, bottom to top (degrees).
    pub angles: Vec<f64>,
    /// Number behind the brackets.
    pub repeat: Option<usize>,
    /// The letter s behind the brackets.
    pub symmetric: bool,
}

/// Reads a stacking sequence. The error tells the character, counted from 1, and what was expected there.
pub(super) fn parse(text: &str) -> Result<Stacking, String> {
    let mut p = Parser { characters: text.chars().collect(), at: 0 };
    p.expect('[', "a stacking sequence begins with '['")?;
    let angles = p.plies(']', 0)?;
    let underscore = p.take('_');
    let repeat = p.count_here()?;
    let symmetric = p.take('s') || p.take('S');
    if underscore && repeat.is_none() && !symmetric {
        return Err(p.wrong("a number or 's' after '_'"));
    }
    match p.peek() {
        None => Ok(Stacking { angles, repeat, symmetric }),
        Some(_) => Err(p.wrong("the end; after ']' there may be a number of repeats and 's' for symmetric")),
    }
}

struct Parser {
    characters: Vec<char>,
    at: usize,
}

impl Parser {
    /// The next character that is not a blank.
    fn peek(&mut self) -> Option<char> {
        while self.characters.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
        self.characters.get(self.at).copied()
    }

    fn take(&mut self, c: char) -> bool {
        let found = self.peek() == Some(c);
        if found {
            self.at += 1;
        }
        found
    }

    fn expect(&mut self, c: char, otherwise: &str) -> Result<(), String> {
        if self.take(c) { Ok(()) } else { Err(self.wrong(otherwise)) }
    }

    fn wrong(&mut self, expected: &str) -> String {
        match self.peek() {
            Some(c) => format!("character {} is '{c}'; expected: {expected}", self.at + 1),
            None => format!("it ends too early; expected: {expected}"),
        }
    }

    /// Groups up to the bracket `end`, which is taken too.
    fn plies(&mut self, end: char, depth: usize) -> Result<Vec<f64>, String> {
        let mut out = Vec::new();
        loop {
            let (group, count) = if self.take('(') {
                if depth == DEEPEST {
                    return Err(format!("more than {DEEPEST} brackets within brackets"));
                }
                let group = self.plies(')', depth + 1)?;
                let count = if self.take('_') { Some(self.count()?) } else { self.count_here()? };
                (group, count)
            } else {
                let group = self.angle()?;
                let count = if self.take('_') { Some(self.count()?) } else { None };
                (group, count)
            };
            let count = count.unwrap_or(1);
            if group.len().saturating_mul(count).saturating_add(out.len()) > MOST_PLIES {
                return Err(format!("it has more than {MOST_PLIES} plies"));
            }
            for _ in 0..count {
                out.extend_from_slice(&group);
            }
            if self.take(end) {
                return Ok(out);
            }
            self.expect('/', &format!("'/' before the next ply or '{end}'"))?;
        }
    }

    /// An angle, or two for ±.
    fn angle(&mut self) -> Result<Vec<f64>, String> {
        let signs: &[f64] = match self.peek() {
            Some('±') => &[1.0, -1.0],
            Some('∓') => &[-1.0, 1.0],
            Some('+') => &[1.0],
            // The hyphen and the minus sign.
            Some('-' | '−') => &[-1.0],
            _ => &[],
        };
        if !signs.is_empty() {
            self.at += 1;
        }
        let signs = match (signs, self.peek()) {
            (&[1.0], Some('-' | '−')) => &[1.0, -1.0],
            (&[-1.0], Some('+')) => &[-1.0, 1.0],
            (&[1.0], Some('/')) => {
                return Err(self.wrong("a number; both signs are written ± or +-"));
            }
            _ => signs,
        };
        if signs.len() == 2 && matches!(self.peek(), Some('-' | '−' | '+')) {
            self.at += 1;
        }
        let start = match self.peek() {
            Some(c) if c.is_ascii_digit() || c == '.' => self.at,
            _ => return Err(self.wrong("an angle in degrees")),
        };
        while self.characters.get(self.at).is_some_and(|c| c.is_ascii_digit() || *c == '.') {
            self.at += 1;
        }
        let number: String = self.characters[start..self.at].iter().collect();
        let value: f64 =
            number.parse().map_err(|_| format!("'{number}' at character {} is not a number", start + 1))?;
        self.take('°');
        Ok(if signs.is_empty() { vec![value] } else { signs.iter().map(|s| s * value).collect() })
    }

    /// A count that has to follow.
    fn count(&mut self) -> Result<usize, String> {
        match self.count_here()? {
            Some(n) => Ok(n),
            None => Err(self.wrong("a whole number after '_'")),
        }
    }

    /// A count if digits follow.
    fn count_here(&mut self) -> Result<Option<usize>, String> {
        if !self.peek().is_some_and(|c| c.is_ascii_digit()) {
            return Ok(None);
        }
        let start = self.at;
        while self.characters.get(self.at).is_some_and(char::is_ascii_digit) {
            self.at += 1;
        }
        let digits: String = self.characters[start..self.at].iter().collect();
        match digits.parse() {
            Ok(n) if (1..=MOST_PLIES).contains(&n) => Ok(Some(n)),
            _ => Err(format!("the count {digits} at character {} must be from 1 to {MOST_PLIES}", start + 1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn angles(text: &str) -> Vec<f64> {
        parse(text).unwrap().angles
    }

    #[test]
    fn sequences_of_textbooks() {
        let s = parse("[0/90]s").unwrap();
        assert_eq!(s, Stacking { angles: vec![0.0, 90.0], repeat: None, symmetric: true });
        assert_eq!(angles("[0_2/90_2]s"), [0.0, 0.0, 90.0, 90.0]);
        let s = parse("[±45/0]2s").unwrap();
        assert_eq!(s, Stacking { angles: vec![45.0, -45.0, 0.0], repeat: Some(2), symmetric: true });
        assert_eq!(angles("[(0/90)2/45]"), [0.0, 90.0, 0.0, 90.0, 45.0]);
        assert_eq!(parse("[0/90/±45]_2S").unwrap(), parse(" [ 0 / 90° / +-45 ] 2s ").unwrap());
        assert_eq!(
            parse("[30]_4").unwrap(),
            Stacking { angles: vec![30.0], repeat: Some(4), symmetric: false }
        );
    }

    #[test]
    fn signs_counts_and_nests() {
        assert_eq!(angles("[∓30_2]"), [-30.0, 30.0, -30.0, 30.0]);
        assert_eq!(angles("[-+22.5/−10/+5]"), [-22.5, 22.5, -10.0, 5.0]);
        assert_eq!(angles("[((0/15)_2/90)2]"), [0.0, 15.0, 0.0, 15.0, 90.0, 0.0, 15.0, 0.0, 15.0, 90.0]);
    }

    #[test]
    fn mistakes_are_placed() {
        for (text, message) in [
            ("0/90", "character 1 is '0'; expected: a stacking sequence begins with '['"),
            ("[0/90", "it ends too early; expected: '/' before the next ply or ']'"),
            ("[0/9o]s", "character 5 is 'o'; expected: '/' before the next ply or ']'"),
            ("[0,90]", "character 3 is ','; expected: '/' before the next ply or ']'"),
            ("[0//90]", "character 4 is '/'; expected: an angle in degrees"),
            ("[]", "character 2 is ']'; expected: an angle in degrees"),
            ("[+/-45]", "character 3 is '/'; expected: a number; both signs are written ± or +-"),
            ("[0_/90]", "character 4 is '/'; expected: a whole number after '_'"),
            ("[0_0]", "the count 0 at character 4 must be from 1 to 10000"),
            ("[0_20000]", "the count 20000 at character 4 must be from 1 to 10000"),
            ("[(0_9999/0)2]", "it has more than 10000 plies"),
            ("[1.2.3]", "'1.2.3' at character 2 is not a number"),
            ("[(0/90]", "character 7 is ']'; expected: '/' before the next ply or ')'"),
            ("[0/90]x", "character 7 is 'x'; expected: the end"),
            ("[0/90]_", "it ends too early; expected: a number or 's' after '_'"),
        ] {
            let found = parse(text).unwrap_err();
            assert!(found.starts_with(message), "{text}: {found}");
        }
        let deep = format!("[{}0{}]", "(".repeat(100_000), ")".repeat(100_000));
        assert_eq!(parse(&deep).unwrap_err(), "more than 16 brackets within brackets");
    }
}
