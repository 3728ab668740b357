//! Every message about syntax, word for word.

use super::errors;

#[test]
fn numbers_are_written_with_digits_and_a_point() {
    insta::assert_snapshot!(errors("x = 1."), @r#"
    m.toml:1:7: a number needs digits on both sides of its decimal point
      help: write 1.0 instead of 1. and 0.5 instead of .5
    "#);
    insta::assert_snapshot!(errors("x = .5"), @r#"
    m.toml:1:5: a number needs digits on both sides of its decimal point
      help: write 1.0 instead of 1. and 0.5 instead of .5
    "#);
    insta::assert_snapshot!(errors("x = 0,5"), @r#"
    m.toml:1:6: a comma stands outside of a list
      help: write the decimal point as a dot, 0.5, and lists in brackets, [1, 2]
    "#);
    insta::assert_snapshot!(errors("w = 01"), @r#"
    m.toml:1:5: a number begins with a zero
      help: leave out the leading zeros
    "#);
    insta::assert_snapshot!(errors("u = 3 m"), @r#"
    m.toml:1:5: "3 m" is not a value
      help: write a plain number such as 1.5e3, without units, formulas or commas
    "#);
    insta::assert_snapshot!(errors("h = 1.5.2"), @r#"
    m.toml:1:8: this is not a number
      help: write a plain number such as 1.5e3
    "#);
    insta::assert_snapshot!(errors("h = +-1"), @r#"
    m.toml:1:6: a number has two signs
      help: keep one of them
    "#);
    insta::assert_snapshot!(errors("m = 5e"), @r#"
    m.toml:1:7: a number needs digits behind its e
      help: write 1e5 or 1.5e-3
    "#);
    insta::assert_snapshot!(errors("x = 0xzz"), @r#"
    m.toml:1:7: this is not valid TOML: invalid hexadecimal number
      help: the format of the file is described at https://toml.io
    "#);
}

#[test]
fn a_file_of_json_is_told_once() {
    insta::assert_snapshot!(errors("\n{\n \"analysis\": {\"type\": \"static\"},\n \"loads\": []\n}"), @r#"
    m.toml:2:1: this is not TOML, but looks like JSON
      help: write tables such as [analysis] and lines key = value; in Python tegula.Model(json.load(file)) takes the same keys from JSON
    "#);
}

#[test]
fn texts_stand_in_quotes_that_are_closed() {
    insta::assert_snapshot!(errors("type = static"), @r#"
    m.toml:1:8: text must stand in quotes: static
      help: write "static"
    "#);
    insta::assert_snapshot!(errors("z = \"abc"), @r#"
    m.toml:1:9: the string has no end
      help: close it on the same line with the quote it begins with
    "#);
    insta::assert_snapshot!(errors("z = 'abc"), @r#"
    m.toml:1:9: the string has no end
      help: close it on the same line with the quote it begins with
    "#);
    insta::assert_snapshot!(errors("z = '''abc"), @r#"
    m.toml:1:11: the string has no end
      help: close it with the three quotes it begins with
    "#);
    insta::assert_snapshot!(errors("x = \"a\\k\""), @r#"
    m.toml:1:8: a backslash begins a special character here
      help: write paths with /, or put the string in single quotes
    "#);
    insta::assert_snapshot!(errors("q = True"), @r#"
    m.toml:1:5: "True" is not a value
      help: write true or false in small letters
    "#);
    insta::assert_snapshot!(errors("x = 1\nx = 2\n\ny = abc"), @r#"
    m.toml:2:1: "x" is given twice
      help: keep one of them
    m.toml:4:5: text must stand in quotes: abc
      help: write "abc"
    "#);
}

#[test]
fn keys_stand_alone_before_one_equals_sign() {
    insta::assert_snapshot!(errors("x 3"), @r#"
    m.toml:1:3: the key x has no value
      help: write one key = value on each line; comments begin with #
    "#);
    insta::assert_snapshot!(errors("x: 3"), @r#"
    m.toml:1:2: ":" cannot stand in a key
      help: write key = value, with an equals sign
    "#);
    insta::assert_snapshot!(errors("x y = 2"), @r#"
    m.toml:1:3: the key x has no value
      help: write one key = value on each line; comments begin with #
    "#);
    insta::assert_snapshot!(errors("[]"), @r#"
    m.toml:1:2: the key is missing
      help: write a key here
    "#);
    insta::assert_snapshot!(errors("= 3"), @r#"
    m.toml:1:1: the key is missing
      help: write a key here
    "#);
    insta::assert_snapshot!(errors("y ="), @r#"
    m.toml:1:4: the value is missing
      help: write a value behind the equals sign
    "#);
    insta::assert_snapshot!(errors("ä = 3"), @r#"
    m.toml:1:1: "ä" cannot stand in a key
      help: keys consist of a–z, A–Z, 0–9, _ and -; put other names in quotes
    "#);
    insta::assert_snapshot!(errors("l = 1 r = 2"), @r#"
    m.toml:1:5: "1 r" is not a value
      help: write a plain number such as 1.5e3, without units, formulas or commas
    "#);
    insta::assert_snapshot!(errors("x == 2"), @r#"
    m.toml:1:4: there are two equals signs
      help: write key = value
    "#);
}

#[test]
fn comments_begin_with_a_hash() {
    insta::assert_snapshot!(errors("// note"), @r#"
    m.toml:1:1: this is neither a key nor a comment
      help: begin comments with #
    "#);
    insta::assert_snapshot!(errors("% note"), @r#"
    m.toml:1:1: this is neither a key nor a comment
      help: begin comments with #
    "#);
    insta::assert_snapshot!(errors("# \u{1}"), @r#"
    m.toml:1:3: the comment holds a control character
      help: remove it
    "#);
}

#[test]
fn lists_and_tables_are_closed() {
    insta::assert_snapshot!(errors("[a"), @r#"
    m.toml:1:3: the header has no end
      help: close it with ] on the same line, or ]] if it begins with [[
    "#);
    insta::assert_snapshot!(errors("[[a]"), @r#"
    m.toml:1:5: the header has no end
      help: close it with ] on the same line, or ]] if it begins with [[
    "#);
    insta::assert_snapshot!(errors("l = (1,2)"), @r#"
    m.toml:1:5: lists stand in square brackets
      help: write [x, y, z]
    "#);
    insta::assert_snapshot!(errors("x = [1, 2"), @r#"
    m.toml:1:10: the list has no end
      help: close it with ]
    "#);
    insta::assert_snapshot!(errors("x = [1, 2\ny = 3"), @r#"
    m.toml:2:1: the list has no end here
      help: put commas between its entries and ] behind the last
    "#);
    insta::assert_snapshot!(errors("x = [1,,2]"), @r#"
    m.toml:1:8: there is nothing between two commas
      help: remove one of them
    "#);
    insta::assert_snapshot!(errors("x = {a = 1"), @r#"
    m.toml:1:11: the table in braces has no end
      help: close it with }
    "#);
    insta::assert_snapshot!(errors("x = {a = 1 b = 2}"), @r#"
    m.toml:1:10: "1 b" is not a value
      help: write a plain number such as 1.5e3, without units, formulas or commas
    "#);
}

#[test]
fn keys_are_given_once() {
    insta::assert_snapshot!(errors("a = 1\na = 2"), @r#"
    m.toml:2:1: "a" is given twice
      help: keep one of them
    "#);
    insta::assert_snapshot!(errors("[m.s]\n[m.s]"), @r#"
    m.toml:2:4: "s" is given twice
      help: keep one of them; a list of tables has double brackets, such as [[loads]]
    "#);
    insta::assert_snapshot!(errors("x = 1\nx.y = 2"), @r#"
    m.toml:2:1: "x" is given twice
      help: keep one of them
    "#);
}

#[test]
fn nesting_is_bounded() {
    insta::assert_snapshot!(errors(&"[".repeat(200)), @r#"
    m.toml:1:3: the key is missing
      help: write a key here
    "#);
    insta::assert_snapshot!(errors(&format!("x = {}", "[".repeat(200))), @r#"
    m.toml:1:85: lists or tables are nested too deeply
      help: close the brackets that are left open
    "#);
    insta::assert_snapshot!(errors(&format!("{}x = 1", "a.".repeat(200))), @r#"
    m.toml:1:1: the key has too many dots
      help: shorten it
    "#);
}
