//! Files of the web page, embedded in the binary.

const SCRIPT: &str = "text/javascript; charset=utf-8";

/// Path, content type and content of each file.
pub static FILES: &[(&str, &str, &[u8])] = &[
    ("/", "text/html; charset=utf-8", include_bytes!("page/index.html")),
    ("/page.css", "text/css; charset=utf-8", include_bytes!("page/page.css")),
    ("/favicon.svg", "image/svg+xml", include_bytes!("page/favicon.svg")),
    ("/main.js", SCRIPT, include_bytes!("page/main.js")),
    ("/api.js", SCRIPT, include_bytes!("page/api.js")),
    ("/link.js", SCRIPT, include_bytes!("page/link.js")),
    ("/words.js", SCRIPT, include_bytes!("page/words.js")),
    ("/colours.js", SCRIPT, include_bytes!("page/colours.js")),
    ("/hover.js", SCRIPT, include_bytes!("page/hover.js")),
    ("/canvas.js", SCRIPT, include_bytes!("page/canvas.js")),
    ("/night.js", SCRIPT, include_bytes!("page/night.js")),
    ("/strip.js", SCRIPT, include_bytes!("page/strip.js")),
    ("/field.js", SCRIPT, include_bytes!("page/field.js")),
    ("/dome.js", SCRIPT, include_bytes!("page/dome.js")),
    ("/contours.js", SCRIPT, include_bytes!("page/contours.js")),
    ("/curve.js", SCRIPT, include_bytes!("page/curve.js")),
    ("/tonight.js", SCRIPT, include_bytes!("page/tonight.js")),
    ("/tonight_panel.js", SCRIPT, include_bytes!("page/tonight_panel.js")),
    ("/crossings.js", SCRIPT, include_bytes!("page/crossings.js")),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Limit on the total size of the page, bytes.
    const MAX_BYTES: usize = 300_000;

    #[test]
    fn the_page_is_small_and_loads_nothing_from_elsewhere() {
        let bytes: usize = FILES.iter().map(|(.., bytes)| bytes.len()).sum();
        assert!(bytes < MAX_BYTES, "{bytes} bytes");
        for (path, _, bytes) in FILES {
            let text = std::str::from_utf8(bytes).unwrap();
            let foreign =
                text.match_indices("://").map(|(at, _)| &text[at.saturating_sub(6)..(at + 20).min(text.len())]);
            let foreign: Vec<&str> = foreign.filter(|address| !address.contains("www.w3.org")).collect();
            assert!(foreign.is_empty(), "{path}: {foreign:?}");
            assert!(!text.contains("style=\"") && !text.contains("onclick=") && !text.contains("eval("), "{path}");
        }
    }

    #[test]
    fn every_script_that_is_imported_is_served() {
        for (path, _, bytes) in FILES {
            let text = std::str::from_utf8(bytes).unwrap();
            for line in text.lines().filter(|line| line.starts_with("import ")) {
                let name = line.rsplit("\"./").next().and_then(|rest| rest.strip_suffix("\";")).unwrap();
                assert!(FILES.iter().any(|(path, ..)| path[1..] == *name), "{path} imports {name}");
            }
        }
    }
}
