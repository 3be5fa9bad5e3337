//! The page as Markdown.

use std::error::Error;
use std::fmt::Write as _;

use lapis::project::Report;

use super::{Shown, table};

/// The whole page. Seconds stand in the last table only, under the machine's name.
pub(crate) fn page(shown: &[Shown], machine: &str) -> Result<String, Box<dyn Error>> {
    let mut page = String::from(HEAD);
    for one in shown {
        section(&mut page, one)?;
    }
    writeln!(page, "\n## Beside the paper's\n\n{}", table::table(shown, machine)?.trim_end())?;
    Ok(page)
}

const HEAD: &str = "\
<!-- Written by `cargo run --release --example gallery`: change tools/gallery, not this file. -->

# Gallery

Each model is a mesh, a small solid texture and a project file that says what is painted, cut and drawn. Its command
makes the pictures below it in full size, GLB files for any viewer, and `.lapis` models to cut again. The cubes are the
solid textures alone: 64×64×64 voxels, of which the whole model is made.

Meshes and textures are made by programs under `tools/`; the models are those of the paper's Table 1, with as many
tetrahedra. What the measures mean is explained in [project-file.md](project-file.md#what-the-numbers-mean).
";

fn section(page: &mut String, one: &Shown) -> Result<(), Box<dyn Error>> {
    let (name, title) = (one.model.name, one.model.title);
    writeln!(page, "\n## {title}\n")?;
    wrap(page, one.model.text)?;
    writeln!(page, "\n    lapis run meshes/{name}.toml\n")?;
    for picture in &one.pictures {
        let what = picture.trim_end_matches(".png").replace('-', " ");
        let height = if picture.ends_with("-exemplar.png") { 128 } else { 240 };
        writeln!(page, "<img src=\"images/gallery/{picture}\" height=\"{height}\" alt=\"{what}\">")?;
    }
    writeln!(page)?;
    wrap(page, &format!("*Still to be bettered:* {}", one.model.weak))?;
    let report = &one.report;
    writeln!(
        page,
        "\nProject file [`meshes/{name}.toml`](../meshes/{name}.toml), {}, {} tetrahedra, {} patches.\n",
        kinds(one),
        count(report, "tetrahedra")?,
        count(report, "patches")?,
    )?;
    writeln!(page, "| `layers_mean` | `layers_max` | `angle_mean_deg` | `clump_edge_share` | `sharpness` |")?;
    writeln!(page, "|---|---|---|---|---|")?;
    writeln!(
        page,
        "| {:.1} | {} | {:.1} | {:.2} % | {:.2} |",
        number(report, "layers_mean")?,
        count(report, "layers_max")?,
        number(report, "angle_mean_deg")?,
        100.0 * number(report, "clump_edge_share")?,
        number(report, "sharpness")?,
    )?;
    writeln!(
        page,
        "\n`uncovered` {}, `inverted` {}, `depth_error` {}.",
        count(report, "uncovered")?,
        count(report, "inverted")?,
        number(report, "depth_error")?,
    )?;
    Ok(())
}

/// `texture type 2b`, or with several parts each one's.
fn kinds(one: &Shown) -> String {
    match &one.project.parts[..] {
        [only] => format!("texture type {}", only.kind),
        parts => {
            let each: Vec<String> = parts.iter().map(|p| format!("{} {}", p.name, p.kind)).collect();
            format!("{} parts of texture types {}", parts.len(), each.join(", "))
        }
    }
}

/// Text in lines of at most 110 characters.
pub(crate) fn wrap(page: &mut String, text: &str) -> std::fmt::Result {
    let mut line = String::new();
    for word in text.split_whitespace() {
        if !line.is_empty() && line.chars().count() + word.chars().count() >= 110 {
            writeln!(page, "{line}")?;
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    writeln!(page, "{line}")
}

pub(crate) fn count(report: &Report, name: &str) -> Result<u64, String> {
    let value = report.counts.get(name).or_else(|| report.measures.get(name));
    value.and_then(serde_json::Value::as_u64).ok_or_else(|| format!("the report has no '{name}'"))
}

pub(crate) fn number(report: &Report, name: &str) -> Result<f64, String> {
    let value = report.measures.get(name).or_else(|| report.seconds.get(name));
    value.and_then(serde_json::Value::as_f64).ok_or_else(|| format!("the report has no '{name}'"))
}
