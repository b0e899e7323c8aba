"""Writes the tetrahedra of the current Gmsh model to a file that Sinew reads; shared by make_meshes and convert_mesh."""

import contextlib
import os
import sys

try:
    import gmsh
    import numpy as np
except ImportError as error:
    sys.exit(f"{os.path.basename(sys.argv[0])}: {error}; install python3-gmsh and python3-numpy")

TETRAHEDRON_GMSH = 4
TETRAHEDRON_VTK = 10


class MeshError(Exception):
    """What was found, and what would be right."""


def check_output(path):
    if os.path.splitext(path)[1] not in (".vtk", ".msh"):
        raise MeshError(f"{path}: expected a name ending in .vtk (VTK legacy) or .msh (Gmsh 4.1)")
    folder = os.path.dirname(path) or "."
    if not os.path.isdir(folder):
        raise MeshError(f"{path}: there is no folder {folder}")


@contextlib.contextmanager
def gmsh_session(verbose=False):
    """Gmsh with settings that give the same mesh every time; whatever it throws becomes a MeshError."""
    gmsh.initialize(["-nopopup"])
    try:
        gmsh.option.setNumber("General.Terminal", 1 if verbose else 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        gmsh.option.setNumber("Mesh.RandomSeed", 1)
        yield
    except (MeshError, OSError):
        raise
    except Exception as error:  # the only class that Gmsh throws
        raise MeshError(f"Gmsh: {error}") from error
    finally:
        gmsh.finalize()


def fill_with_tetrahedra(element):
    """Meshes the volumes of the current model; `element` is the edge length in the model's unit."""
    gmsh.option.setNumber("Mesh.CharacteristicLengthMax", element)
    gmsh.option.setNumber("Mesh.CharacteristicLengthMin", element)
    gmsh.option.setNumber("Mesh.Algorithm", 6)  # frontal Delaunay
    gmsh.option.setNumber("Mesh.OptimizeThreshold", 0.5)
    gmsh.model.mesh.generate(3)
    for _ in range(3):
        gmsh.model.mesh.optimize("")
        gmsh.model.mesh.optimize("Relocate3D")


def read_tetrahedra():
    """Nodes (n, 3) in the model's unit, tetrahedra (m, 4) of positive volume, region (m): the first physical group."""
    tags, positions, _ = gmsh.model.mesh.getNodes()
    positions = positions.reshape(-1, 3)
    index = np.zeros(int(tags.max(initial=0)) + 1, dtype=np.int64)
    index[tags.astype(np.int64)] = np.arange(len(tags))
    tets, region = [], []
    for dimension, volume in gmsh.model.getEntities(3):
        types, _, node_tags = gmsh.model.mesh.getElements(dimension, volume)
        groups = gmsh.model.getPhysicalGroupsForEntity(dimension, volume)
        for kind, nodes in zip(types, node_tags):
            if kind == TETRAHEDRON_GMSH:
                tets.append(index[nodes.astype(np.int64)].reshape(-1, 4))
                region.append(np.full(len(tets[-1]), groups[0] if len(groups) else 0))
    if not tets:
        raise MeshError("no tetrahedra")
    tets, region = np.concatenate(tets), np.concatenate(region)
    used, tets = np.unique(tets, return_inverse=True)
    return positions[used], orient(positions[used], tets.reshape(-1, 4)), region


def place_around(nodes, tets, count, distance):
    """Copies around the z axis at `distance`, their y axes towards it; each is a region of its own, counted from 1."""
    everything = []
    for copy in range(count):
        c, s = np.cos(2 * np.pi * copy / count), np.sin(2 * np.pi * copy / count)
        turned = (nodes - [0, distance, 0]) @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        everything.append((turned, tets + copy * len(nodes), np.full(len(tets), copy + 1)))
    return tuple(np.concatenate(parts) for parts in zip(*everything))


def volumes(nodes, tets):
    a, b, c, d = (nodes[tets[:, i]] for i in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6


def orient(nodes, tets):
    inverted = volumes(nodes, tets) < 0
    tets[inverted] = tets[inverted][:, [0, 1, 3, 2]]
    return tets


def write_mesh(path, nodes, tets, region):
    """Nodes in metres. The extension chooses the format."""
    if path.endswith(".vtk"):
        write_vtk(path, nodes, tets, region)
    else:
        write_msh(path, nodes, tets, region)


def write_vtk(path, nodes, tets, region):
    count = len(tets)
    with open(path, "wb") as file:
        file.write(b"# vtk DataFile Version 3.0\nsoft robot, lengths in m\nBINARY\nDATASET UNSTRUCTURED_GRID\n")
        file.write(f"POINTS {len(nodes)} double\n".encode())
        file.write(nodes.astype(">f8").tobytes())
        file.write(f"\nCELLS {count} {5 * count}\n".encode())
        file.write(np.column_stack([np.full(count, 4), tets]).astype(">i4").tobytes())
        file.write(f"\nCELL_TYPES {count}\n".encode())
        file.write(np.full(count, TETRAHEDRON_VTK).astype(">i4").tobytes())
        file.write(f"\nCELL_DATA {count}\nSCALARS region int 1\nLOOKUP_TABLE default\n".encode())
        file.write(region.astype(">i4").tobytes())
        file.write(b"\n")


def write_msh(path, nodes, tets, region):
    """A fresh model with one volume for each region, so that nothing but tetrahedra is written."""
    gmsh.model.add("output")
    for volume, tag in enumerate(np.unique(region), start=1):
        gmsh.model.addDiscreteEntity(3, volume)
        if tag > 0:
            gmsh.model.addPhysicalGroup(3, [volume], int(tag))
        if volume == 1:
            gmsh.model.mesh.addNodes(3, volume, np.arange(1, len(nodes) + 1), nodes.ravel())
        own = tets[region == tag] + 1
        gmsh.model.mesh.addElementsByType(volume, TETRAHEDRON_GMSH, [], own.ravel())
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.option.setNumber("Mesh.Binary", 1)
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    gmsh.write(path)


def calc_quality(nodes, tets):
    """Mean ratio of each tetrahedron: 1 is regular, 0 is flat."""
    squared = sum(
        ((nodes[tets[:, i]] - nodes[tets[:, j]]) ** 2).sum(axis=1) for i in range(4) for j in range(i)
    )
    return 12 * np.cbrt(9 * volumes(nodes, tets) ** 2) / squared


def describe(nodes, tets):
    quality = calc_quality(nodes, tets)
    size = nodes.max(axis=0) - nodes.min(axis=0)
    return (
        f"{len(nodes)} nodes, {len(tets)} tetrahedra, {size[0]:.4g} x {size[1]:.4g} x {size[2]:.4g} m, "
        f"{volumes(nodes, tets).sum() * 1e6:.4g} cm3, quality worst {quality.min():.2f}, mean {quality.mean():.2f}"
    )
