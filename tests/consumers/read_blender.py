"""Blender imports an exported GLB and OBJ: one mesh, all its triangles, one material with its picture.

Usage: python read_blender.py FACES FILE.glb FILE.obj
"""
import os
import sys

import bpy

faces = int(sys.argv[1])
for path in sys.argv[2:]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if path.endswith(".glb"):
        bpy.ops.import_scene.gltf(filepath=path)
    else:
        # The file's own axes.
        bpy.ops.wm.obj_import(filepath=path, forward_axis="Y", up_axis="Z")
    meshes = [o for o in bpy.context.scene.objects if o.type == "MESH"]
    assert len(meshes) == 1, f"{path}: {len(meshes)} meshes"
    mesh = meshes[0].data
    mesh.calc_loop_triangles()
    assert len(mesh.loop_triangles) == faces, f"{path}: {len(mesh.loop_triangles)} triangles, not {faces}"
    assert len(mesh.uv_layers) == 1, f"{path}: {len(mesh.uv_layers)} sets of texture coordinates"
    assert len(mesh.materials) == 1, f"{path}: {len(mesh.materials)} materials"
    images = [n.image for n in mesh.materials[0].node_tree.nodes if n.type == "TEX_IMAGE"]
    assert len(images) == 1 and images[0].size[0] >= 64, f"{path}: its material has no picture"
    print(f"{path}: Blender {bpy.app.version_string} sees {faces} triangles and {mesh.materials[0].name!r}")
sys.stdout.flush()
# Blender's own end takes seconds and says nothing.
os._exit(0)
