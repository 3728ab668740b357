//! HTML of the page.

use crate::report::{STYLE, VIEWER_SCRIPTS, colours};

const SCRIPT: &str = include_str!("../../assets/watch/watch.js");
const OWN_STYLE: &str = include_str!("../../assets/watch/watch.css");
const BODY: &str = include_str!("../../assets/watch/body.html");

/// The page, which is the same for all clients of a run.
pub(super) struct Page {
    /// Text.
    pub html: String,
    /// Header lines of what the page may do.
    pub policy: String,
}

impl Page {
    /// Page whose scripts are told by a random number.
    pub fn new(nonce: &str) -> Self {
        let scripts: String = VIEWER_SCRIPTS
            .iter()
            .chain([&SCRIPT])
            .map(|script| format!("<script nonce=\"{nonce}\">\n{script}\n</script>\n"))
            .collect();
        let html = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>tegula</title>\n\
             <link rel=\"icon\" href=\"data:,\">\n<style nonce=\"{nonce}\">\n{}\n{OWN_STYLE}\n</style>\n</head>\n<body>\n{BODY}\
             <script type=\"application/json\" id=\"colours\">{}</script>\n{scripts}</body>\n</html>\n",
            STYLE.join("\n"),
            colours(),
        );
        let policy = format!(
            "Content-Security-Policy: default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; \
             img-src data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n"
        );
        Self { html, policy }
    }
}
