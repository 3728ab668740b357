//! Values by which whole function bodies are replaced, by the type that the function returns.

use syn::{GenericArgument, PathArguments, ReturnType, Type};

/// Expressions of the type that a function returns; empty where none is known.
pub fn of_return(output: &ReturnType) -> Vec<String> {
    match output {
        ReturnType::Default => vec!["()".into()],
        ReturnType::Type(_, of) => of_type(of),
    }
}

fn of_type(of: &Type) -> Vec<String> {
    let list = |words: &[&str]| words.iter().map(|w| (*w).to_string()).collect::<Vec<_>>();
    match of {
        Type::Path(path) => {
            let Some(last) = path.path.segments.last() else { return vec![] };
            let inner = || argument(&last.arguments).map(of_type).unwrap_or_default();
            let wrapped = |open: &str, close: &str| {
                inner().iter().map(|v| format!("{open}{v}{close}")).collect::<Vec<_>>()
            };
            match last.ident.to_string().as_str() {
                "bool" => list(&["true", "false"]),
                "f32" | "f64" => list(&["0.0", "1.0", "-1.0"]),
                "u8" | "u16" | "u32" | "u64" | "u128" | "usize" => list(&["0", "1"]),
                "i8" | "i16" | "i32" | "i64" | "i128" | "isize" => list(&["0", "1", "-1"]),
                "String" => list(&["String::new()", "\"xyzzy\".into()"]),
                "Option" => [list(&["None"]), wrapped("Some(", ")")].concat(),
                "Vec" => [list(&["vec![]"]), wrapped("vec![", "]")].concat(),
                "Result" => wrapped("Ok(", ")"),
                _ => list(&["Default::default()"]),
            }
        }
        Type::Tuple(tuple) if tuple.elems.is_empty() => list(&["()"]),
        Type::Tuple(tuple) => {
            let firsts: Option<Vec<String>> =
                tuple.elems.iter().map(|t| of_type(t).first().cloned()).collect();
            firsts.map(|f| vec![format!("({})", f.join(", "))]).unwrap_or_default()
        }
        Type::Array(array) => {
            of_type(&array.elem).iter().take(2).map(|e| format!("std::array::from_fn(|_| {e})")).collect()
        }
        Type::Reference(reference) if reference.mutability.is_none() => match &*reference.elem {
            Type::Path(path) if path.path.is_ident("str") => list(&["\"\"", "\"xyzzy\""]),
            Type::Slice(_) => list(&["&[]"]),
            _ => vec![],
        },
        _ => vec![],
    }
}

/// First type argument, `T` of `Option<T>`.
fn argument(arguments: &PathArguments) -> Option<&Type> {
    let PathArguments::AngleBracketed(brackets) = arguments else { return None };
    brackets.args.iter().find_map(|a| if let GenericArgument::Type(t) = a { Some(t) } else { None })
}
