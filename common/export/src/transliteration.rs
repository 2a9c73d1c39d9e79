//! Transliteration of names to ASCII, for folders.

/// Folder names longer than this are cut.
const SLUG_BYTES_MAX: usize = 60;

/// Lower-case ASCII words joined by hyphens; another word if nothing is left.
pub fn slug(name: &str, otherwise: &str) -> String {
    let mut out = String::new();
    for c in name.chars().flat_map(char::to_lowercase) {
        match plain(c) {
            _ if c.is_ascii_alphanumeric() => out.push(c),
            Some(letters) => out.push_str(letters),
            None if !out.is_empty() && !out.ends_with('-') => out.push('-'),
            None => {}
        }
    }
    out.truncate(SLUG_BYTES_MAX);
    let slug = out.trim_end_matches('-');
    if slug.is_empty() { otherwise.to_owned() } else { slug.to_owned() }
}

/// ASCII letters for a lower-case letter of the Latin alphabets; `None` for everything else.
fn plain(c: char) -> Option<&'static str> {
    Some(match c {
        'à'..='ã' | 'å' | 'ā' | 'ă' | 'ą' => "a",
        'ä' | 'æ' => "ae",
        'ç' | 'ć' | 'ĉ' | 'ċ' | 'č' => "c",
        'ď' | 'đ' | 'ð' => "d",
        'è'..='ë' | 'ē' | 'ĕ' | 'ė' | 'ę' | 'ě' => "e",
        'ĝ' | 'ğ' | 'ġ' | 'ģ' => "g",
        'ĥ' | 'ħ' => "h",
        'ì'..='ï' | 'ĩ' | 'ī' | 'ĭ' | 'į' | 'ı' => "i",
        'ĵ' => "j",
        'ķ' => "k",
        'ĺ' | 'ļ' | 'ľ' | 'ŀ' | 'ł' => "l",
        'ñ' | 'ń' | 'ņ' | 'ň' | 'ŋ' => "n",
        'ò'..='õ' | 'ø' | 'ō' | 'ŏ' | 'ő' => "o",
        'ö' | 'œ' => "oe",
        'ŕ' | 'ŗ' | 'ř' => "r",
        'ś' | 'ŝ' | 'ş' | 'š' | 'ș' => "s",
        'ß' => "ss",
        'ţ' | 'ť' | 'ŧ' | 'ț' => "t",
        'þ' => "th",
        'ù'..='û' | 'ũ' | 'ū' | 'ŭ' | 'ů' | 'ű' | 'ų' => "u",
        'ü' => "ue",
        'ŵ' => "w",
        'ý' | 'ÿ' | 'ŷ' => "y",
        'ź' | 'ż' | 'ž' => "z",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slugs_are_ascii_words() {
        assert_eq!(slug("Erdgeschoß / Küche (1)", "storey"), "erdgeschoss-kueche-1");
        assert_eq!(slug("00 Begane grond", "storey"), "00-begane-grond");
        assert_eq!(slug("Piętro pierwsze", "storey"), "pietro-pierwsze");
        assert_eq!(slug("地下", "storey"), "storey");
        assert_eq!(slug(&"a ".repeat(100), "storey").len(), SLUG_BYTES_MAX - 1, "cut, and no hyphen at the end");
    }
}
