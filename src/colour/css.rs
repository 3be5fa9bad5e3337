//! Colours in words and digits, as CSS writes them.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// A colour: 8-bit sRGB with straight alpha. Written as in CSS: `#rgb`, `#rgba`, `#rrggbb`,
/// `#rrggbbaa`, or one of CSS's basic names or `transparent`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Colour(pub [u8; 4]);

impl Colour {
    /// Opaque white.
    pub const WHITE: Self = Self([255; 4]);
    /// Nothing at all.
    pub const TRANSPARENT: Self = Self([0; 4]);
}

/// A colour that nobody knows.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no colour; write #rrggbb, #rrggbbaa, transparent, or a name such as white, black, grey")]
pub struct ColourError(pub String);

const NAMES: [(&str, [u8; 4]); 19] = [
    ("transparent", [0; 4]),
    ("white", [255; 4]),
    ("black", [0, 0, 0, 255]),
    ("grey", [128, 128, 128, 255]),
    ("gray", [128, 128, 128, 255]),
    ("silver", [192, 192, 192, 255]),
    ("maroon", [128, 0, 0, 255]),
    ("red", [255, 0, 0, 255]),
    ("purple", [128, 0, 128, 255]),
    ("fuchsia", [255, 0, 255, 255]),
    ("green", [0, 128, 0, 255]),
    ("lime", [0, 255, 0, 255]),
    ("olive", [128, 128, 0, 255]),
    ("yellow", [255, 255, 0, 255]),
    ("orange", [255, 165, 0, 255]),
    ("navy", [0, 0, 128, 255]),
    ("blue", [0, 0, 255, 255]),
    ("teal", [0, 128, 128, 255]),
    ("aqua", [0, 255, 255, 255]),
];

impl FromStr for Colour {
    type Err = ColourError;

    fn from_str(text: &str) -> Result<Self, ColourError> {
        let lower = text.trim().to_ascii_lowercase();
        if let Some((_, colour)) = NAMES.iter().find(|(name, _)| *name == lower) {
            return Ok(Self(*colour));
        }
        lower.strip_prefix('#').and_then(hex).map(Self).ok_or_else(|| ColourError(text.to_owned()))
    }
}

fn hex(digits: &str) -> Option<[u8; 4]> {
    let nibbles: Vec<u8> =
        digits.chars().map(|c| c.to_digit(16).and_then(|d| u8::try_from(d).ok())).collect::<Option<_>>()?;
    let channels: Vec<u8> = match nibbles.len() {
        3 | 4 => nibbles.iter().map(|n| n * 17).collect(),
        6 | 8 => nibbles.chunks(2).map(|n| n[0] * 16 + n[1]).collect(),
        _ => return None,
    };
    Some([channels[0], channels[1], channels[2], channels.get(3).copied().unwrap_or(255)])
}

impl fmt::Display for Colour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [r, g, b, a] = self.0;
        if let Some((name, _)) = NAMES[..3].iter().find(|(_, colour)| *colour == self.0) {
            f.write_str(name)
        } else if a == 255 {
            write!(f, "#{r:02x}{g:02x}{b:02x}")
        } else {
            write!(f, "#{r:02x}{g:02x}{b:02x}{a:02x}")
        }
    }
}

impl TryFrom<String> for Colour {
    type Error = ColourError;

    fn try_from(text: String) -> Result<Self, ColourError> {
        text.parse()
    }
}

impl From<Colour> for String {
    fn from(colour: Colour) -> Self {
        colour.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn css_colours_are_read_and_written() {
        for (text, colour, written) in [
            ("#ff8000", [255, 128, 0, 255], "#ff8000"),
            ("#FF800040", [255, 128, 0, 64], "#ff800040"),
            ("#f80", [255, 136, 0, 255], "#ff8800"),
            ("#f808", [255, 136, 0, 136], "#ff880088"),
            (" White ", [255; 4], "white"),
            ("transparent", [0; 4], "transparent"),
            ("teal", [0, 128, 128, 255], "#008080"),
        ] {
            let c: Colour = text.parse().unwrap();
            assert_eq!(c.0, colour, "{text}");
            assert_eq!(c.to_string(), written);
            assert_eq!(written.parse::<Colour>().unwrap(), c);
        }
    }

    #[test]
    fn other_words_are_refused() {
        for text in ["", "#", "#12", "#12345", "#gggggg", "whit", "#ééé", "ffffff"] {
            assert!(text.parse::<Colour>().is_err(), "{text}");
        }
    }
}
