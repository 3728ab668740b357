//! Parser of formulas: from the text to a program in postfix order, by precedence climbing (Pratt 1973).
//!
//! | binds | operators | groups |
//! |---|---|---|
//! | least | `+` `-` | from the left |
//! | | `*` `/` | from the left |
//! | | signs before an operand | |
//! | most | `^` | from the left: `2^3^2` is `(2^3)^2` |
//!
//! A function takes the operand right behind it: `sin(t)^2` is `(sin(t))^2`.

use super::jet::{Function, Number, Operator};

/// Largest number of characters of a formula.
pub(super) const LONGEST: usize = 4096;
/// Largest nesting depth of brackets, signs and operators; also the size of the operand stack.
pub(super) const DEEPEST: usize = 64;

/// Functions that are common in other programs but have kinks or jumps, so that they cannot be differentiated.
const ROUGH: [&str; 11] =
    ["abs", "signum", "floor", "round", "ceil", "trunc", "fract", "cbrt", "atan2", "min", "max"];
const CONSTANTS: [(&str, f64); 6] = [
    ("PI", std::f64::consts::PI),
    ("π", std::f64::consts::PI),
    ("E", std::f64::consts::E),
    ("e", std::f64::consts::E),
    ("TAU", std::f64::consts::TAU),
    ("τ", std::f64::consts::TAU),
];

/// One instruction of a program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Instruction {
    /// A number.
    Constant(f64),
    /// A variable, by its number.
    Variable(u8),
    /// Function of the last operand.
    Apply(Function),
    /// Operator between the last two operands.
    Combine(Operator),
}

/// Value of a program at these variables; the parser guarantees that its operands fit on the stack and that there are no other variables.
pub(super) fn evaluate<N: Number, const V: usize>(program: &[Instruction], variables: [N; V]) -> N {
    let mut stack = [N::constant(0.0); DEEPEST];
    let mut height = 0;
    for instruction in program {
        match *instruction {
            Instruction::Constant(value) => {
                stack[height] = N::constant(value);
                height += 1;
            }
            Instruction::Variable(number) => {
                stack[height] = variables[usize::from(number)];
                height += 1;
            }
            Instruction::Apply(function) => stack[height - 1] = N::apply(function, stack[height - 1]),
            Instruction::Combine(operator) => {
                height -= 1;
                stack[height - 1] = N::combine(operator, stack[height - 1], stack[height]);
            }
        }
    }
    stack[0]
}

/// Names that a formula may use.
#[derive(Debug, Clone, Copy)]
pub(super) struct Names {
    /// Variables, by number.
    pub variables: &'static [&'static str],
    /// Whether functions with kinks, [`KINKED`] and [`EXTREMES`], are taken.
    pub kinks: bool,
}

/// Functions of one number that are continuous and have a kink.
pub(super) const KINKED: [(&str, Function); 1] = [("abs", Function::Abs)];
/// Functions of two numbers that are continuous and have a kink.
pub(super) const EXTREMES: [(&str, Operator); 2] = [("min", Operator::Min), ("max", Operator::Max)];

#[derive(Debug, Clone, Copy, PartialEq)]
enum Token {
    Number(f64),
    Variable(u8),
    Function(Function),
    /// Function of two numbers.
    Extreme(Operator),
    Comma,
    Operator(char),
    Open,
    Close,
}

/// Parses a formula into a program.
///
/// # Errors
/// The text is not a valid formula: the reason, which continues the sentence *the expression …*.
pub(super) fn parse(text: &str, names: Names) -> Result<Vec<Instruction>, String> {
    let tokens = tokens(text, names)?;
    let mut parser = Parser { tokens: &tokens, at: 0, program: Vec::new(), operands: 0 };
    parser.sum(0)?;
    match parser.peek() {
        None => Ok(parser.program),
        Some(Token::Close) => Err("closes a bracket that was not opened".into()),
        Some(Token::Comma) => Err(stray_comma()),
        Some(_) => Err(incomplete()),
    }
}

fn stray_comma() -> String {
    "has a comma; write a point for decimals".into()
}

fn incomplete() -> String {
    "is not a formula: an operator or a number is missing".into()
}

fn too_deep() -> String {
    format!("has more than {DEEPEST} brackets, signs or powers within each other")
}

fn tokens(text: &str, names: Names) -> Result<Vec<Token>, String> {
    let mut out = Vec::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let length = match c {
            '0'..='9' | '.' => {
                let length = number(rest);
                let value = rest[..length].parse::<f64>();
                out.push(Token::Number(
                    value.map_err(|_| format!("has the number \"{}\"", &rest[..length]))?,
                ));
                length
            }
            '+' | '-' | '*' | '/' | '^' => {
                out.push(Token::Operator(c));
                1
            }
            '(' => {
                out.push(Token::Open);
                1
            }
            ')' => {
                out.push(Token::Close);
                1
            }
            c if c.is_alphabetic() || c == '_' => {
                let length = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
                let (name, behind) = rest.split_at(length);
                out.push(named(name, behind, names)?);
                length
            }
            c if c.is_whitespace() => c.len_utf8(),
            ',' if out.iter().any(|token| matches!(token, Token::Extreme(_))) => {
                out.push(Token::Comma);
                1
            }
            ',' => return Err(stray_comma()),
            c => return Err(format!("holds the character {c:?}, which has no meaning in a formula")),
        };
        rest = &rest[length..];
    }
    Ok(out)
}

/// Length of the number at the beginning of a text; the letter of an exponent belongs to the number and is no name.
fn number(text: &str) -> usize {
    let digits = |s: &str| s.find(|c: char| !c.is_ascii_digit()).unwrap_or(s.len());
    let mut end = digits(text);
    if text[end..].starts_with('.') {
        end += 1;
        end += digits(&text[end..]);
    }
    if let Some(exponent) = text[end..].strip_prefix(['e', 'E']) {
        let unsigned = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
        if digits(unsigned) > 0 {
            end = text.len() - unsigned.len() + digits(unsigned);
        }
    }
    end
}

fn named(name: &str, behind: &str, names: Names) -> Result<Token, String> {
    if let Some(number) = (0..).zip(names.variables).find_map(|(i, known)| (*known == name).then_some(i)) {
        return Ok(Token::Variable(number));
    }
    if names.kinks {
        if let Some((_, function)) = KINKED.into_iter().find(|(known, _)| *known == name) {
            return Ok(Token::Function(function));
        }
        if let Some((_, extreme)) = EXTREMES.into_iter().find(|(known, _)| *known == name) {
            return Ok(Token::Extreme(extreme));
        }
    }
    if let Some((_, function)) = Function::NAMED.into_iter().find(|(known, _)| *known == name) {
        return Ok(Token::Function(function));
    }
    if let Some((_, value)) = CONSTANTS.into_iter().find(|(known, _)| *known == name) {
        return Ok(Token::Number(value));
    }
    Err(if ROUGH.contains(&name) {
        format!("uses \"{name}\", which cannot be differentiated")
    } else if behind.trim_start().starts_with('(') {
        format!("uses a function \"{name}\" that does not exist")
    } else {
        format!("has an unknown variable \"{name}\"")
    })
}

struct Parser<'a> {
    tokens: &'a [Token],
    at: usize,
    program: Vec<Instruction>,
    /// Operands on the stack at this point of the program.
    operands: usize,
}

impl Parser<'_> {
    fn peek(&self) -> Option<Token> {
        self.tokens.get(self.at).copied()
    }

    /// Consumes and returns the next token if it is one of these operators.
    fn accept(&mut self, operators: &str) -> Option<char> {
        match self.peek() {
            Some(Token::Operator(c)) if operators.contains(c) => {
                self.at += 1;
                Some(c)
            }
            _ => None,
        }
    }

    /// Consumes a token, or ends with this problem.
    fn expect(&mut self, token: Token, problem: &str) -> Result<(), String> {
        if self.peek() != Some(token) {
            return Err(problem.into());
        }
        self.at += 1;
        Ok(())
    }

    fn emit(&mut self, instruction: Instruction) -> Result<(), String> {
        match instruction {
            Instruction::Constant(_) | Instruction::Variable(_) => self.operands += 1,
            Instruction::Combine(_) => self.operands -= 1,
            Instruction::Apply(_) => {}
        }
        self.program.push(instruction);
        if self.operands > DEEPEST { Err(too_deep()) } else { Ok(()) }
    }

    fn sum(&mut self, depth: usize) -> Result<(), String> {
        self.product(depth)?;
        while let Some(sign) = self.accept("+-") {
            self.product(depth)?;
            self.emit(Instruction::Combine(if sign == '+' { Operator::Add } else { Operator::Subtract }))?;
        }
        Ok(())
    }

    fn product(&mut self, depth: usize) -> Result<(), String> {
        self.signed(depth)?;
        while let Some(sign) = self.accept("*/") {
            self.signed(depth)?;
            self.emit(Instruction::Combine(if sign == '*' { Operator::Multiply } else { Operator::Divide }))?;
        }
        Ok(())
    }

    /// Signs before a power; they apply to the whole power: `-t^2` means `-(t^2)`.
    fn signed(&mut self, depth: usize) -> Result<(), String> {
        let mut negative = false;
        while let Some(sign) = self.accept("+-") {
            negative ^= sign == '-';
        }
        self.power(depth)?;
        if negative { self.emit(Instruction::Apply(Function::Negate)) } else { Ok(()) }
    }

    fn power(&mut self, depth: usize) -> Result<(), String> {
        self.operand(depth)?;
        while self.accept("^").is_some() {
            // A sign behind the operator belongs to the exponent, with all powers behind it.
            match self.peek() {
                Some(Token::Operator('+' | '-')) if depth < DEEPEST => self.signed(depth + 1)?,
                Some(Token::Operator('+' | '-')) => return Err(too_deep()),
                _ => self.operand(depth)?,
            }
            self.emit(Instruction::Combine(Operator::Power))?;
        }
        Ok(())
    }

    fn operand(&mut self, depth: usize) -> Result<(), String> {
        if depth > DEEPEST {
            return Err(too_deep());
        }
        let token = self.peek();
        self.at += 1;
        match token {
            Some(Token::Number(value)) => self.emit(Instruction::Constant(value)),
            Some(Token::Variable(number)) => self.emit(Instruction::Variable(number)),
            Some(Token::Extreme(operator)) => {
                let pair = "writes \"min\" or \"max\" without two arguments in brackets, as in max(x, 0)";
                self.expect(Token::Open, pair)?;
                self.sum(depth + 1)?;
                self.expect(Token::Comma, pair)?;
                self.sum(depth + 1)?;
                self.expect(Token::Close, pair)?;
                self.emit(Instruction::Combine(operator))
            }
            Some(Token::Function(function)) => {
                let mut negative = false;
                while let Some(sign) = self.accept("+-") {
                    negative ^= sign == '-';
                }
                // Brackets around an argument count as a level of their own.
                let bracketed = matches!(self.peek(), Some(Token::Open));
                self.operand(if bracketed { depth } else { depth + 1 })?;
                if negative {
                    self.emit(Instruction::Apply(Function::Negate))?;
                }
                self.emit(Instruction::Apply(function))
            }
            Some(Token::Open) => {
                self.sum(depth + 1)?;
                match self.peek() {
                    Some(Token::Close) => {
                        self.at += 1;
                        Ok(())
                    }
                    None => Err("leaves a bracket open".into()),
                    Some(Token::Comma) => Err(stray_comma()),
                    Some(_) => Err(incomplete()),
                }
            }
            Some(Token::Close) => {
                // Brackets are counted here only to tell the two mistakes apart.
                let open = self.tokens[..self.at].iter().fold(0_i64, |n, t| match t {
                    Token::Open => n + 1,
                    Token::Close => n - 1,
                    _ => n,
                });
                Err(if open < 0 { "closes a bracket that was not opened".into() } else { incomplete() })
            }
            None if self.tokens.contains(&Token::Open) && unbalanced(self.tokens) => {
                Err("leaves a bracket open".into())
            }
            _ => Err(incomplete()),
        }
    }
}

fn unbalanced(tokens: &[Token]) -> bool {
    let count = |token: Token| tokens.iter().filter(|&&t| t == token).count();
    count(Token::Open) > count(Token::Close)
}
