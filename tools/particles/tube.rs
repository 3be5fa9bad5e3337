//! The brick volume along a bent tube, by plain lapping.

use std::error::Error;
use std::fs;
use std::path::Path;

use lapis::exec::Exec;
use lapis::files::write_whole;
use lapis::mesh::Mesher;
use lapis::project::{self, Project, RunOptions};
use lapis::render::Picture;
use lapis::volume::{self, SolidTexture};

use crate::contact;

const PROJECT: &str = include_str!("brick-tube.toml");
const MESH: &str = include_str!("../../meshes/tube.obj");
const PICTURES: [&str; 3] = ["whole", "across", "lengthwise"];
const WIDTH: u32 = 1560;

/// Fills and cuts it in the folder `out`, and lays its pictures side by side.
pub(crate) fn make(bricks: &SolidTexture, out: &Path) -> Result<(), Box<dyn Error>> {
    let file = out.join("bricks-turned.nrrd");
    for (path, bytes) in volume::to_files(&file, &turned(bricks)?)? {
        write_whole(&path, &bytes)?;
    }
    write_whole(&out.join("tube.obj"), MESH.as_bytes())?;
    write_whole(&out.join("brick-tube.toml"), PROJECT.as_bytes())?;
    let project = Project::read(&out.join("brick-tube.toml"))?;
    let folder = out.join("brick-tube");
    let options = RunOptions { mesher: Mesher::find(None), seed: None, force: true };
    let report = project::run(&project, &folder, &options, &Exec::default())?;
    eprintln!("{}", serde_json::to_string(&report)?);
    let read = |name: &str| -> Result<Picture, Box<dyn Error>> {
        square(&Picture::from_png(&fs::read(folder.join(format!("{name}.png")))?)?)
    };
    let pictures: Vec<Picture> = PICTURES.into_iter().map(read).collect::<Result<_, _>>()?;
    let sheet = contact::jpeg(&[pictures.iter().map(contact::picture).collect()], WIDTH)?;
    Ok(write_whole(&out.join("brick-tube.jpg"), &sheet)?)
}

/// The volume with y and z exchanged.
fn turned(texture: &SolidTexture) -> Result<SolidTexture, Box<dyn Error>> {
    let [nx, ny, nz] = texture.size();
    let places = || (0..ny).flat_map(move |k| (0..nz).flat_map(move |j| (0..nx).map(move |i| (i, k, j))));
    let voxels = places().map(|(i, j, k)| texture.voxel(i, j, k)).collect();
    let labels = places().map(|(i, j, k)| texture.label(i, j, k).unwrap_or(0)).collect();
    let [x, y, z] = texture.tiles();
    Ok(SolidTexture::new([nx, nz, ny], voxels, [x, z, y])?.with_labels(labels)?)
}

/// The picture with room above and below.
fn square(picture: &Picture) -> Result<Picture, Box<dyn Error>> {
    let side = picture.width.max(picture.height);
    let (left, top) = ((side - picture.width) / 2, (side - picture.height) / 2);
    let pixel = |n: u32| {
        let (x, y) = ((n % side).wrapping_sub(left), (n / side).wrapping_sub(top));
        if x < picture.width && y < picture.height { picture.pixel(x, y) } else { [0; 4] }
    };
    Ok(Picture { width: side, height: side, rgba: (0..side * side).map(pixel).collect() })
}
