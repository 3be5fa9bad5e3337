//! Wavefront MTL: the colours and pictures of an OBJ file's materials.

use std::path::Path;

use super::pictures::{Alpha, Pictures};
use super::text::{Lines, number, shown, words};
use super::{below, note, short};
use crate::colour::byte;
use crate::files;
use crate::mesh::{Material, Wrap};

/// A material, and how its picture lies.
pub(super) struct Described {
    pub(super) material: Material,
    /// What texture coordinates are multiplied by, and what is then added (`-s`, `-o`), v upwards.
    pub(super) scale: [f32; 2],
    pub(super) offset: [f32; 2],
}

/// Reads the materials that the file `name` beside an OBJ describes. What cannot be read becomes a note.
pub(super) fn read(
    folder: &Path,
    name: &str,
    pictures: &mut Pictures,
    notes: &mut Vec<String>,
) -> Vec<Described> {
    let bytes = match beside(folder, name) {
        Ok(bytes) => bytes,
        Err(why) => {
            note(notes, format!("the materials {}: {why}", short(name)));
            return Vec::new();
        }
    };
    let mut materials: Vec<Described> = Vec::new();
    let mut lines = Lines::new(&bytes);
    while let Some(line) = lines.next() {
        let line = line.trim_ascii();
        let parts: Vec<&[u8]> = words(line).collect();
        let Some((keyword, values)) = parts.split_first() else { continue };
        let mut wrong = |what: &str| {
            note(notes, format!("{}, line {}: {what}", short(name), lines.number()));
        };
        let keyword = keyword.to_ascii_lowercase();
        if keyword == b"newmtl" {
            let name = super::obj::joined(values);
            let material = Material { name, colour: [255; 4], ..Material::default() };
            materials.push(Described { material, scale: [1.0; 2], offset: [0.0; 2] });
            continue;
        }
        let Some(now) = materials.last_mut() else { continue };
        match keyword.as_slice() {
            b"kd" => match colour(values) {
                Some([r, g, b]) => now.material.colour[..3].copy_from_slice(&[r, g, b]),
                None => wrong("Kd is taken as white: it is no three numbers"),
            },
            b"d" | b"tr" => match values.last().and_then(|w| number::<f32>(w)) {
                Some(x) => {
                    let alpha = byte(x);
                    now.material.colour[3] = if keyword == b"d" { alpha } else { 255 - alpha };
                }
                None => wrong("its opacity is taken as 1: it is no number"),
            },
            b"map_kd" => {
                let rest = line[keyword.len()..].trim_ascii();
                let Some(map) = map(rest) else {
                    wrong(&format!("{} names no picture", shown(rest)));
                    continue;
                };
                now.scale = map.scale;
                now.offset = map.offset;
                now.material.wrap = [map.wrap; 2];
                let read = || beside(folder, &map.name);
                let failed = |why| note(notes, format!("the picture {}: {why}", short(&map.name)));
                now.material.picture = pictures.get(&map.name, Alpha::Blend, read, failed);
            }
            b"map_d" => wrong("a picture of opacity (map_d) is passed over"),
            _ => {}
        }
    }
    materials
}

/// Red, green, blue as bytes; one number serves for all.
fn colour(values: &[&[u8]]) -> Option<[u8; 3]> {
    let numbers: Vec<f32> = values.iter().take(3).map_while(|w| number(w)).collect();
    match numbers.as_slice() {
        [all] => Some([byte(*all); 3]),
        [r, g, b] => Some([*r, *g, *b].map(byte)),
        _ => None,
    }
}

/// A file beside the OBJ or below its folder. One that is named by a whole path is looked for by its last
/// part, since such paths seldom outlive the machine that they were written on.
fn beside(folder: &Path, name: &str) -> Result<Vec<u8>, String> {
    let name = name.replace('\\', "/");
    let last = name.rsplit('/').next().unwrap_or(&name);
    let named = below(folder, &name).filter(|path| path.is_file());
    let path = named.or_else(|| below(folder, last)).ok_or("no name of a file")?;
    files::read_whole(&path).map_err(|e| e.to_string())
}

/// What a `map_Kd` line says.
struct Map {
    name: String,
    scale: [f32; 2],
    offset: [f32; 2],
    wrap: Wrap,
}

/// Options, each with its numbers or words, then the name (which may have spaces).
fn map(mut rest: &[u8]) -> Option<Map> {
    let mut map = Map { name: String::new(), scale: [1.0; 2], offset: [0.0; 2], wrap: Wrap::Repeat };
    let word = |rest: &mut &[u8]| {
        *rest = rest.trim_ascii_start();
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let (word, after) = rest.split_at(end);
        *rest = after;
        word.to_vec()
    };
    loop {
        let before = rest;
        let option = word(&mut rest).to_ascii_lowercase();
        let numbers = match option.as_slice() {
            b"-s" | b"-o" | b"-t" => 1..=3,
            b"-mm" => 2..=2,
            b"-bm" | b"-boost" | b"-texres" => 1..=1,
            b"-clamp" => {
                map.wrap =
                    if word(&mut rest).eq_ignore_ascii_case(b"on") { Wrap::Clamp } else { Wrap::Repeat };
                continue;
            }
            b"-blendu" | b"-blendv" | b"-cc" | b"-imfchan" | b"-type" => {
                word(&mut rest);
                continue;
            }
            _ => {
                let name = String::from_utf8_lossy(before.trim_ascii()).into_owned();
                let name = name.trim_matches('"').to_owned();
                return (!name.is_empty()).then_some(Map { name, ..map });
            }
        };
        let mut values: Vec<f32> = Vec::new();
        while values.len() < *numbers.end() {
            let before = rest;
            match number::<f32>(&word(&mut rest)) {
                Some(x) => values.push(x),
                None => {
                    rest = before;
                    break;
                }
            }
        }
        if values.len() < *numbers.start() {
            return None;
        }
        let target = match option.as_slice() {
            b"-s" => &mut map.scale,
            b"-o" => &mut map.offset,
            _ => continue,
        };
        for (to, x) in target.iter_mut().zip(values).filter(|(_, x)| x.is_finite()) {
            *to = x;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_come_before_the_name() {
        let of = |line: &str| {
            let map = map(line.as_bytes()).unwrap();
            (map.name, map.scale, map.offset)
        };
        assert_eq!(of("a b.png"), ("a b.png".to_owned(), [1.0; 2], [0.0; 2]));
        assert_eq!(
            of("-s 2 3 1 -o 0.5 -clamp on -bm 1 -mm 0 1 my tex.jpg"),
            ("my tex.jpg".to_owned(), [2.0, 3.0], [0.5, 0.0])
        );
        // A name of digits after a full set of numbers.
        assert_eq!(of("-o 1 2 3 4.png").0, "4.png");
        assert_eq!(map(b"-clamp on a.png").unwrap().wrap, Wrap::Clamp);
        assert_eq!(map(b"-clamp off a.png").unwrap().wrap, Wrap::Repeat);
        assert!(map(b"").is_none() && map(b"-bm x.png").is_none());
    }
}
