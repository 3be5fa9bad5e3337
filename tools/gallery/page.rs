//! The page as Markdown.

use std::error::Error;
use std::fmt::Write as _;

use lapis::project::Report;

use super::Shown;

/// The whole page. Seconds stand in the last table only, under the machine's name.
pub(crate) fn page(shown: &[Shown], machine: &str) -> Result<String, Box<dyn Error>> {
    let mut page = String::from(HEAD);
    for one in shown {
        section(&mut page, one)?;
    }
    table(&mut page, shown, machine)?;
    Ok(page)
}

const HEAD: &str = "\
<!-- Written by `cargo run --release --example gallery`: change tools/gallery, not this file. -->

# Gallery

Each model is a mesh, a small solid texture and a project file that says what is painted, cut and drawn. Its command
makes the pictures below it in full size, GLB files for any viewer, and `.lapis` models to cut again. The cube is the
solid texture alone: 64×64×64 voxels, of which the whole model is made.

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
    let report = &one.report;
    writeln!(
        page,
        "\nProject file [`meshes/{name}.toml`](../meshes/{name}.toml), texture type {}, {} tetrahedra, {} patches.\n",
        one.project.part.kind,
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

fn table(page: &mut String, shown: &[Shown], machine: &str) -> Result<(), Box<dyn Error>> {
    writeln!(page, "\n## Beside the paper's\n")?;
    wrap(
        page,
        &format!(
            "Table 1 of Takayama et al. 2008 (a notebook with 2.3 GHz and 1 GB of 2008) and Lapis, on {machine}. \
             Filling is all from the fields to the patches; the paper's cut is without subdividing the tetrahedra, \
             ours ends with each piece a model of its own, a mean over the project's cuts. Sizes are those of the \
             filled model with its texture."
        ),
    )?;
    writeln!(
        page,
        "\n| | tetrahedra: paper | Lapis | filling: paper | Lapis | times faster | a cut: paper | Lapis | size: paper | \
         Lapis | layers |"
    )?;
    writeln!(page, "|---|---|---|---|---|---|---|---|---|---|---|")?;
    for one in shown {
        let Some(paper) = &one.model.paper else { continue };
        let fill = number(&one.report, "fields")? + number(&one.report, "fill")?;
        let cut = 1000.0 * number(&one.report, "cut")? / one.project.cuts.len().max(1) as f64;
        writeln!(
            page,
            "| {} | {} | {} | {:.0} s | {fill:.1} s | {:.0} | {:.0} ms | {cut:.0} ms | {:.1} MB | {:.1} MB | {:.1} |",
            one.model.title,
            paper.tetrahedra,
            count(&one.report, "tetrahedra")?,
            paper.fill_s,
            paper.fill_s / fill,
            paper.cut_ms,
            paper.megabytes,
            one.bytes as f64 / 1e6,
            number(&one.report, "layers_mean")?,
        )?;
    }
    Ok(())
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
