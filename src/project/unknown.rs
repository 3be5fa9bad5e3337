//! Error messages of TOML, with a hint where a key is misspelt.

use std::fmt;

/// What is wrong with a TOML text, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Complaint {
    /// Line, counted from 1, where that is known.
    pub line: Option<usize>,
    /// What is wrong, and what would help.
    pub message: String,
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "line {line}: {}", self.message),
            None => f.write_str(&self.message),
        }
    }
}

impl std::error::Error for Complaint {}

/// The complaint of `toml` about `text`, with the nearest known key where a key is unknown.
pub(super) fn complaint(text: &str, error: &toml::de::Error) -> Complaint {
    let line = error.span().map(|span| {
        text.as_bytes()[..span.start.min(text.len())].iter().filter(|&&b| b == b'\n').count() + 1
    });
    let message = hint(error.message()).unwrap_or_else(|| error.message().to_owned());
    Complaint { line, message }
}

/// Serde says "unknown field `skn`, expected one of `skin`, `stroke`"; which of them was meant?
fn hint(message: &str) -> Option<String> {
    let kind = ["field", "variant"].into_iter().find(|k| message.starts_with(&format!("unknown {k} `")))?;
    let mut words = message.split('`').skip(1).step_by(2);
    let unknown = words.next()?;
    let known: Vec<&str> = words.collect();
    let noun = if kind == "field" { "key" } else { "word" };
    let nearest = known
        .iter()
        .map(|k| (strsim::damerau_levenshtein(unknown, k), *k))
        .min()
        .filter(|(distance, k)| *distance <= 1 + k.len().max(unknown.len()) / 3);
    Some(match nearest {
        Some((_, k)) => format!("unknown {noun} '{unknown}'; did you mean '{k}'?"),
        None if known.is_empty() => format!("unknown {noun} '{unknown}'; none is expected here"),
        None => format!("unknown {noun} '{unknown}'; known here: {}", known.join(", ")),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct Depth {
        skin: f64,
        stroke: Option<String>,
    }

    fn complain(text: &str) -> String {
        complaint(text, &toml::from_str::<Depth>(text).unwrap_err()).to_string()
    }

    #[test]
    fn a_misspelt_key_finds_its_neighbour() {
        assert_eq!(
            complain("skin = 1\nstorke = \"a\""),
            "line 2: unknown key 'storke'; did you mean 'stroke'?"
        );
        assert_eq!(complain("\n\ncolour = 1"), "line 3: unknown key 'colour'; known here: skin, stroke");
        assert!(complain("skin = true").starts_with("line 1: invalid type: boolean"));
        assert!(complain("skin =").starts_with("line 1: "));
    }
}
