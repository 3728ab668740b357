//! Places of a file at which it is mutated.

use std::ops::Range;

use proc_macro2::{Delimiter, Span, TokenStream, TokenTree};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Attribute, BinOp, Block, Expr, ReturnType, UnOp};

use crate::defaults;

/// One small error.
pub struct Mutant {
    pub number: u32,
    pub line: usize,
    pub column: usize,
    pub function: String,
    pub kind: &'static str,
    pub original: String,
    pub replacement: String,
}

/// Bytes of the file.
pub type Bytes = Range<usize>;
/// Numbers of mutants and the text that each has in place of the original one.
pub type Choices = Vec<(u32, String)>;

/// Parts of an expression or of a function that the writer puts together anew.
pub enum Parts {
    /// `left operator right` of values.
    Binary { left: Bytes, operator: String, right: Bytes },
    /// Comparison, which only borrows.
    Comparison { left: Bytes, operator: String, right: Bytes },
    /// `&&` or `||`; the other one is its mutant.
    Logical { left: Bytes, operator: String, right: Bytes },
    /// `left += right`.
    Assignment { left: Bytes, operator: String, right: Bytes },
    /// `-value`, `!value`; the mutant leaves the operator out.
    Unary { operator: String, value: Bytes },
    /// Call of an operation of a vector register, `lanes.add(a, b)`.
    Register { receiver: String, method: String, arguments: Vec<Bytes> },
    /// Body of a function with its mutants, from the first number to the last; they return a value at once. It is written twice,
    /// with mutants and without, unless its type has no name or it is inlined always.
    Body { last: u32, twice: bool },
}

/// Place with one or more mutants.
pub struct Site {
    pub range: Bytes,
    pub parts: Parts,
    pub choices: Choices,
    pub first: u32,
}

/// Visitor that finds the places and numbers the mutants.
pub struct Collector<'a> {
    text: &'a str,
    pub next: u32,
    pub sites: Vec<Site>,
    pub mutants: Vec<Mutant>,
    functions: Vec<String>,
    types: Vec<String>,
}

/// Operators that replace an operator, those of cargo-mutants.
fn replacements(operator: &str) -> &'static [&'static str] {
    match operator {
        "+" => &["-", "*"],
        "-" => &["+", "/"],
        "*" => &["+", "/"],
        "/" => &["%", "*"],
        "%" => &["/", "+"],
        "<" => &["==", ">", "<="],
        ">" => &["==", "<", ">="],
        "<=" => &[">"],
        ">=" => &["<"],
        "==" => &["!="],
        "!=" => &["=="],
        "&&" => &["||"],
        "||" => &["&&"],
        "+=" => &["-=", "*="],
        "-=" => &["+=", "/="],
        "*=" => &["+=", "/="],
        "/=" => &["%=", "*="],
        _ => &[],
    }
}

/// True for code that only tests compile.
fn only_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|a| {
        let is_cfg_test = a.path().is_ident("cfg")
            && a.meta
                .require_list()
                .is_ok_and(|list| list.tokens.to_string().split(' ').any(|w| w == "test"));
        is_cfg_test || a.path().segments.last().is_some_and(|s| s.ident == "test")
    })
}

fn has_let(expression: &Expr) -> bool {
    match expression {
        Expr::Let(_) => true,
        Expr::Binary(b) => has_let(&b.left) || has_let(&b.right),
        Expr::Paren(p) => has_let(&p.expr),
        _ => false,
    }
}

impl<'a> Collector<'a> {
    pub fn new(text: &'a str, next: u32) -> Self {
        Self { text, next, sites: vec![], mutants: vec![], functions: vec![], types: vec![] }
    }

    fn add(&mut self, at: Span, kind: &'static str, original: &str, replacement: &str) -> u32 {
        let (number, start) = (self.next, at.start());
        self.next += 1;
        let function = self.types.iter().chain(&self.functions).cloned().collect::<Vec<_>>().join("::");
        self.mutants.push(Mutant {
            number,
            line: start.line,
            column: start.column + 1,
            function,
            kind,
            original: original.split_whitespace().collect::<Vec<_>>().join(" "),
            replacement: replacement.to_string(),
        });
        number
    }

    fn source(&self, range: &Bytes) -> &'a str {
        &self.text[range.clone()]
    }

    /// Adds the mutants of an operator; the place must lie in a function.
    fn operator(&mut self, at: Span, range: Bytes, kind: &'static str, operator: &str, parts: Parts) {
        let (first, original) = (self.next, self.source(&range));
        let mut choices = Choices::new();
        for other in replacements(operator) {
            let kind =
                if matches!((operator, *other), ("<", "<=") | (">", ">=")) { "boundary" } else { kind };
            choices.push((self.add(at, kind, original, other), (*other).to_string()));
        }
        self.sites.push(Site { range, parts, choices, first });
    }

    fn function(&mut self, attributes: &[Attribute], signature: &syn::Signature, body: &Block) {
        if only_tests(attributes) || signature.constness.is_some() || self.skips(signature) {
            return;
        }
        self.functions.push(signature.ident.to_string());
        let range = body.span().byte_range();
        let inside = self.text[range.start + 1..range.end - 1].trim();
        let opaque = matches!(&signature.output, ReturnType::Type(_, t) if self.source(&t.span().byte_range()).contains("impl "));
        // Nested functions that are inlined always would double the code at each level.
        let inlined = attributes.iter().any(|a| {
            a.path().is_ident("inline")
                && a.meta.require_list().is_ok_and(|list| list.tokens.to_string() == "always")
        });
        let (first, at) = (self.next, self.sites.len());
        let mut choices = Choices::new();
        for value in defaults::of_return(&signature.output) {
            if !opaque && inside != value && !(inside.is_empty() && value == "()") {
                let original = format!("body of {}", signature.ident);
                choices.push((
                    self.add(signature.ident.span(), "body", &original, &format!("return {value}")),
                    value,
                ));
            }
        }
        visit::visit_block(self, body);
        let last = self.next - 1;
        if last >= first {
            self.sites.insert(
                at,
                Site { range, parts: Parts::Body { last, twice: !opaque && !inlined }, choices, first },
            );
        }
        self.functions.pop();
    }

    /// Texts for developers and default values are not mutated.
    fn skips(&self, signature: &syn::Signature) -> bool {
        let formats =
            self.types.last().is_some_and(|t| t.starts_with("Debug for") || t.starts_with("Display for"));
        formats || signature.ident == "default" && signature.inputs.is_empty()
    }

    /// Mutants of operations of vector registers in the tokens of a macro inside a function.
    fn registers(&mut self, tokens: TokenStream) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        for (at, token) in tokens.iter().enumerate() {
            if let TokenTree::Group(group) = token {
                self.registers(group.stream());
            }
            let [
                TokenTree::Ident(receiver),
                TokenTree::Punct(dot),
                TokenTree::Ident(method),
                TokenTree::Group(group),
                ..,
            ] = &tokens[at..]
            else {
                continue;
            };
            let inner = group.span_open().byte_range().end..group.span_close().byte_range().start;
            if dot.as_char() != '.' || group.delimiter() != Delimiter::Parenthesis {
                continue;
            }
            let commas: Vec<Bytes> = group
                .stream()
                .into_iter()
                .filter(|t| matches!(t, TokenTree::Punct(p) if p.as_char() == ','))
                .map(|t| t.span().byte_range())
                .collect();
            let starts = [inner.start].into_iter().chain(commas.iter().map(|c| c.end));
            let ends = commas.iter().map(|c| c.start).chain([inner.end]);
            let arguments = starts.zip(ends).map(|(start, end)| start..end).collect();
            let range = receiver.span().byte_range().start..group.span_close().byte_range().end;
            self.register(method.span(), range, &receiver.to_string(), &method.to_string(), arguments);
        }
    }

    fn register(&mut self, at: Span, range: Bytes, receiver: &str, method: &str, arguments: Vec<Bytes>) {
        let other = match (method, arguments.len()) {
            ("add", 2) => format!("{receiver}.sub(l__, r__)"),
            ("sub", 2) => format!("{receiver}.add(l__, r__)"),
            ("mul", 2) => format!("{receiver}.add(l__, r__)"),
            ("mul_add", 3) => format!("{receiver}.sub({receiver}.mul(l__, r__), s__)"),
            _ => return,
        };
        if receiver != "l" && receiver != "lanes" {
            return;
        }
        let first = self.next;
        let number = self.add(at, "register", self.source(&range), &other);
        let parts = Parts::Register { receiver: receiver.into(), method: method.into(), arguments };
        self.sites.push(Site { range, parts, choices: vec![(number, other)], first });
    }
}

impl<'ast> Visit<'ast> for Collector<'_> {
    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.function(&item.attrs, &item.sig, &item.block);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.function(&item.attrs, &item.sig, &item.block);
    }

    fn visit_trait_item_fn(&mut self, item: &'ast syn::TraitItemFn) {
        if let Some(body) = &item.default {
            self.function(&item.attrs, &item.sig, body);
        }
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !only_tests(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        if only_tests(&item.attrs) {
            return;
        }
        let of = self.source(&item.self_ty.span().byte_range());
        let name = match &item.trait_ {
            Some((_, path, _)) => {
                format!("{} for {of}", path.segments.last().map(|s| s.ident.to_string()).unwrap_or_default())
            }
            None => of.to_string(),
        };
        self.types.push(name);
        visit::visit_item_impl(self, item);
        self.types.pop();
    }

    fn visit_stmt(&mut self, statement: &'ast syn::Stmt) {
        let attributes = match statement {
            syn::Stmt::Local(local) => &local.attrs[..],
            syn::Stmt::Macro(call) => &call.attrs[..],
            syn::Stmt::Expr(Expr::Call(call), _) => &call.attrs[..],
            syn::Stmt::Expr(Expr::Block(block), _) => &block.attrs[..],
            _ => &[],
        };
        if !only_tests(attributes) {
            visit::visit_stmt(self, statement);
        }
    }

    // Constants and types are computed by the compiler, patterns are no expressions.
    fn visit_item_const(&mut self, _: &'ast syn::ItemConst) {}
    fn visit_item_static(&mut self, _: &'ast syn::ItemStatic) {}
    fn visit_impl_item_const(&mut self, _: &'ast syn::ImplItemConst) {}
    fn visit_trait_item_const(&mut self, _: &'ast syn::TraitItemConst) {}
    fn visit_expr_const(&mut self, _: &'ast syn::ExprConst) {}
    fn visit_type(&mut self, _: &'ast syn::Type) {}
    fn visit_path(&mut self, _: &'ast syn::Path) {}
    fn visit_pat(&mut self, _: &'ast syn::Pat) {}
    fn visit_generics(&mut self, _: &'ast syn::Generics) {}
    fn visit_attribute(&mut self, _: &'ast Attribute) {}
    fn visit_variant(&mut self, _: &'ast syn::Variant) {}

    fn visit_expr_repeat(&mut self, repeat: &'ast syn::ExprRepeat) {
        self.visit_expr(&repeat.expr);
    }

    fn visit_item_macro(&mut self, item: &'ast syn::ItemMacro) {
        if !self.functions.is_empty() {
            self.registers(item.mac.tokens.clone());
        }
    }

    fn visit_expr_method_call(&mut self, call: &'ast syn::ExprMethodCall) {
        if let Expr::Path(path) = &*call.receiver
            && let Some(receiver) = path.path.get_ident()
            && !self.functions.is_empty()
        {
            let arguments = call.args.iter().map(|a| a.span().byte_range()).collect();
            let range = call.span().byte_range();
            self.register(
                call.method.span(),
                range,
                &receiver.to_string(),
                &call.method.to_string(),
                arguments,
            );
        }
        visit::visit_expr_method_call(self, call);
    }

    fn visit_expr_binary(&mut self, binary: &'ast syn::ExprBinary) {
        let (left, right) = (binary.left.span().byte_range(), binary.right.span().byte_range());
        let operator = self.source(&binary.op.span().byte_range()).to_string();
        let (range, at) = (binary.span().byte_range(), binary.op.span());
        let word = operator.clone();
        let found = match binary.op {
            BinOp::Add(_) | BinOp::Sub(_) | BinOp::Mul(_) | BinOp::Div(_) | BinOp::Rem(_) => {
                Some(("arithmetic", Parts::Binary { left, operator, right }))
            }
            BinOp::Lt(_) | BinOp::Le(_) | BinOp::Gt(_) | BinOp::Ge(_) | BinOp::Eq(_) | BinOp::Ne(_) => {
                Some(("comparison", Parts::Comparison { left, operator, right }))
            }
            BinOp::And(_) | BinOp::Or(_) => Some(("logical", Parts::Logical { left, operator, right })),
            BinOp::AddAssign(_) | BinOp::SubAssign(_) | BinOp::MulAssign(_) | BinOp::DivAssign(_) => {
                Some(("assignment", Parts::Assignment { left, operator, right }))
            }
            _ => None,
        };
        if let Some((kind, parts)) = found
            && !self.functions.is_empty()
            && !(has_let(&binary.left) || has_let(&binary.right))
        {
            self.operator(at, range, kind, &word, parts);
        }
        visit::visit_expr_binary(self, binary);
    }

    fn visit_expr_unary(&mut self, unary: &'ast syn::ExprUnary) {
        let operator = match unary.op {
            UnOp::Neg(_) => "-",
            UnOp::Not(_) => "!",
            _ => "",
        };
        if !operator.is_empty() && !self.functions.is_empty() {
            let (range, value) = (unary.span().byte_range(), unary.expr.span().byte_range());
            let first = self.next;
            let without = self.source(&value).to_string();
            let number = self.add(unary.op.span(), "sign", self.source(&range), &without);
            let parts = Parts::Unary { operator: operator.into(), value };
            self.sites.push(Site { range, parts, choices: vec![(number, String::new())], first });
        }
        visit::visit_expr_unary(self, unary);
    }
}
