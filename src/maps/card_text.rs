//! Text for the cards of a FITS header: ASCII, and no longer than a card.

/// The longest text of one card, in which a quote counts twice; CFITSIO would cut it without a word.
const LONGEST: usize = 68;

/// The end of a text that was cut.
const CUT: &str = "...";

/// Letters and signs that have a near kin in ASCII.
const KIN: &[(&str, &str)] = &[
    ("ÀÁÂÃÄÅĀĂĄ", "A"),
    ("àáâãäåāăą", "a"),
    ("Æ", "AE"),
    ("æ", "ae"),
    ("ÇĆČĊ", "C"),
    ("çćčċ", "c"),
    ("ĎĐÐ", "D"),
    ("ďđð", "d"),
    ("ÈÉÊËĒĖĘĚ", "E"),
    ("èéêëēėęě", "e"),
    ("ĞĢĠ", "G"),
    ("ğģġ", "g"),
    ("ÌÍÎÏĪĮİ", "I"),
    ("ìíîïīįı", "i"),
    ("Ķ", "K"),
    ("ķ", "k"),
    ("ŁĽĻĹ", "L"),
    ("łľļĺ", "l"),
    ("ÑŃŇŅ", "N"),
    ("ñńňņ", "n"),
    ("ÒÓÔÕÖØŌŐ", "O"),
    ("òóôõöøōő", "o"),
    ("Œ", "OE"),
    ("œ", "oe"),
    ("ŘŔ", "R"),
    ("řŕ", "r"),
    ("ŚŠŞȘ", "S"),
    ("śšşș", "s"),
    ("ß", "ss"),
    ("ŤŢȚ", "T"),
    ("ťţț", "t"),
    ("Þ", "Th"),
    ("þ", "th"),
    ("ÙÚÛÜŪŮŰŲ", "U"),
    ("ùúûüūůűų", "u"),
    ("ŴẀẂẄ", "W"),
    ("ŵẁẃẅ", "w"),
    ("ÝŸŶ", "Y"),
    ("ýÿŷ", "y"),
    ("ŹŻŽ", "Z"),
    ("źżž", "z"),
    ("‘’ʻʼ", "'"),
    ("“”", "\""),
    ("‐‑–—−", "-"),
    ("°", "deg"),
    ("…", "..."),
    ("\u{a0}\u{202f}", " "),
];

/// Text as a card can hold it: accents left out, `?` for what has no kin in ASCII, three dots at the end of what was too long.
pub(super) fn card_text(text: &str) -> String {
    let plain: String = text.chars().map(|c| in_ascii(c).unwrap_or_else(|| c.to_string())).collect();
    let width = |c: char| if c == '\'' { 2 } else { 1 };
    if plain.chars().map(width).sum::<usize>() <= LONGEST {
        return plain;
    }
    let mut end = 0;
    let fits = |c: &char| {
        end += width(*c);
        end + CUT.len() <= LONGEST
    };
    let mut cut: String = plain.chars().take_while(fits).collect();
    cut.push_str(CUT);
    cut
}

/// What stands for a character in a card; `None` for itself.
fn in_ascii(c: char) -> Option<String> {
    let is_combining_mark = ('\u{300}'..='\u{36f}').contains(&c);
    match c {
        ' '..='~' => None,
        _ if is_combining_mark => Some(String::new()),
        _ => Some(KIN.iter().find(|(kin, _)| kin.contains(c)).map_or("?", |(_, ascii)| ascii).to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_names_stay_readable() {
        for (name, card) in [
            ("Río Grande, Côte d’Azur", "Rio Grande, Cote d'Azur"),
            ("Ondřejov – Žebrák", "Ondrejov - Zebrak"),
            ("Skalnate\u{301} Pleso 20°", "Skalnate Pleso 20deg"),
            ("Straße, Ærø, Þórshöfn, İzmir", "Strasse, AEro, Thorshofn, Izmir"),
            ("紫金山 / Zijinshan\t", "??? / Zijinshan?"),
            ("~ plain ~", "~ plain ~"),
        ] {
            assert_eq!(card_text(name), card);
        }
    }

    #[test]
    fn verif_what_is_cut_says_so() {
        let (fits, long) = ("x".repeat(68), "x".repeat(69));
        assert_eq!(card_text(&fits), fits);
        assert_eq!(card_text(&long), format!("{}...", "x".repeat(65)));
        // A quote takes two places in the card.
        assert_eq!(card_text(&"'".repeat(34)), "'".repeat(34));
        assert_eq!(card_text(&"'".repeat(35)), format!("{}...", "'".repeat(32)));
    }
}
