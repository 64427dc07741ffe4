"""From a label image to smooth surfaces that fit together."""

import gzip
import json

import meshes
import numpy as np
import pytest
import pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy

from vtksmooth import InvalidMeshError, MeshFileError, ParameterError, SegmentationSurface
from vtksmooth.cli import main
from vtksmooth.files import read_image


def image_of(voxels, dtype=np.uint8, **keywords):
    image = pv.ImageData(dimensions=voxels.shape, **keywords)
    image["tissue"] = voxels.astype(dtype).ravel(order="F")
    return image


def sides_of(surface):
    return np.asarray(surface.cell_data["BoundaryLabels"])


def volumes_of(surface):
    """The volume of every label, pyramid by pyramid."""
    p = surface.points[surface.regular_faces]
    volume = np.einsum("ij,ij->i", p[:, 0], np.cross(p[:, 1], p[:, 2])) / 6
    sides = sides_of(surface)
    return {
        label: volume[sides[:, 0] == label].sum() - volume[sides[:, 1] == label].sum()
        for label in np.unique(sides)
    }


def open_edges(surface):
    edges = surface.extract_feature_edges(
        boundary_edges=True, feature_edges=False, manifold_edges=False, non_manifold_edges=False
    )
    return edges.n_cells


def tilted():
    direction = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
    return image_of(
        meshes.grains(10, 4), spacing=(1.0, 0.5, 2.0), origin=(100.0, -7.0, 3.0), direction_matrix=direction
    )


IMAGES = {
    "grains": lambda: image_of(meshes.grains(10, 4)),
    "speckle": lambda: image_of(meshes.speckle((5, 6, 7), 4)),
    "touching the border": lambda: image_of(np.pad(np.ones((2, 3, 3)), ((0, 2), (0, 0), (0, 0)))),
    "anisotropic, turned": tilted,
    "64 bits": lambda: image_of(np.where(meshes.grains(9, 3) == 2, 2**62, -meshes.grains(9, 3)), np.int64),
    "floats": lambda: image_of(meshes.grains(9, 3), np.float32),
    "one voxel": lambda: image_of(np.pad(np.ones((1, 1, 1)), 2)),
}


@pytest.mark.parametrize("name", IMAGES)
def test_every_label_keeps_the_volume_of_its_voxels(name):
    image = IMAGES[name]()
    voxels = np.asarray(image["tissue"]).astype(np.int64)
    segmentation = SegmentationSurface()
    surface = pv.wrap(segmentation(image))
    assert surface.points.dtype == np.float64
    volumes = volumes_of(surface)
    labels = [label for label in np.unique(voxels) if label != 0]
    assert [each.label for each in segmentation.report.labels] == labels
    for each in segmentation.report.labels:
        count = (voxels == each.label).sum() * np.prod(image.spacing)
        assert each.voxels == (voxels == each.label).sum()
        assert volumes[each.label] == pytest.approx(count, rel=1e-11)
        assert each.volume_before == pytest.approx(count, rel=1e-12)
        assert abs(each.change) < 1e-12
    assert segmentation.report.inverted == (0, 0)
    # Where there is background, normals run towards it.
    sides = sides_of(surface)
    assert (sides[:, 0] != 0).all()
    assert segmentation.report.moved > 0.9 * surface.n_points or name == "one voxel"


def test_without_smoothing_the_voxels_are_left():
    image = tilted()
    surface = pv.wrap(SegmentationSurface(iterations=0)(image))
    # In voxels, corners are halfway between the points of the image.
    voxels = np.linalg.solve(
        np.asarray(image.direction_matrix) * np.array(image.spacing), (surface.points - image.origin).T
    ).T
    assert abs(voxels - np.round(voxels - 0.5) - 0.5).max() < 1e-9


def test_lines_and_faces_become_smooth():
    image = image_of(meshes.grains(24, 6))
    rough, smooth = (pv.wrap(SegmentationSurface(iterations=n)(image)) for n in (0, 20))
    radius = [
        np.linalg.norm(s.points[np.unique(s.regular_faces[(sides_of(s) == 0).any(axis=1)])] - 11.5, axis=1)
        for s in (rough, smooth)
    ]
    assert np.std(radius[1]) < 0.4 * np.std(radius[0])
    np.testing.assert_array_equal(rough.regular_faces, smooth.regular_faces)


def test_separate_surfaces_are_closed_and_share_points_bit_for_bit():
    image = image_of(meshes.grains(10, 4))
    whole = pv.wrap(SegmentationSurface()(image))
    blocks = pv.wrap(SegmentationSurface(separate=True)(image))
    assert blocks.keys() == ["1", "2", "3", "4"]
    known = {point.tobytes() for point in whole.points}
    count = 0
    for label in map(str, range(1, 5)):
        block = blocks[label]
        assert open_edges(block) == 0
        assert block.volume == pytest.approx((np.asarray(image["tissue"]) == int(label)).sum(), rel=1e-12)
        assert {point.tobytes() for point in block.points} <= known
        count += block.n_cells
    assert count == whole.n_cells + (sides_of(whole) != 0).all(axis=1).sum()


def test_chosen_labels_only():
    voxels = meshes.grains(10, 4)
    segmentation = SegmentationSurface(labels="1,3-4")
    surface = pv.wrap(segmentation(image_of(voxels)))
    assert np.unique(sides_of(surface)).tolist() == [0, 1, 3, 4]
    assert [each.voxels for each in segmentation.report.labels] == [
        (voxels == label).sum() for label in (1, 3, 4)
    ]


def test_another_background():
    voxels = meshes.grains(10, 4) + 5
    surface = pv.wrap(SegmentationSurface(background=5)(image_of(voxels)))
    assert (sides_of(surface)[:, 1] == 5).any()
    assert volumes_of(surface)[6] == pytest.approx((voxels == 6).sum())


def test_the_border_closed_or_open():
    voxels = np.pad(np.ones((3, 4, 4), int), ((0, 3), (2, 2), (2, 2)))
    closed = pv.wrap(SegmentationSurface()(image_of(voxels)))
    opened = pv.wrap(SegmentationSurface(border="open")(image_of(voxels)))
    assert open_edges(closed) == 0
    assert open_edges(opened) == 16
    on_border = opened.points[:, 0] == 0.5 * (opened.points[:, 0].min() * 2)
    before = pv.wrap(SegmentationSurface(border="open", iterations=0)(image_of(voxels)))
    assert on_border.sum() == 16
    np.testing.assert_array_equal(opened.points[on_border], before.points[on_border])


def test_labels_of_cells():
    voxels = meshes.grains(10, 4)
    cells = pv.ImageData(dimensions=np.array(voxels.shape) + 1, origin=(-0.5,) * 3)
    cells.cell_data["tissue"] = voxels.ravel(order="F")
    np.testing.assert_array_equal(
        pv.wrap(SegmentationSurface()(cells)).points, pv.wrap(SegmentationSurface()(image_of(voxels))).points
    )


@pytest.mark.parametrize(
    ("image", "parameters", "error", "message"),
    [
        (lambda: image_of(np.zeros((4, 4, 4))), {}, InvalidMeshError, "nothing but the background"),
        (lambda: image_of(np.ones((4, 4, 4))), {"border": "open"}, InvalidMeshError, "one label fills it"),
        (lambda: image_of(np.ones((4, 4, 1))), {}, InvalidMeshError, "flat"),
        (lambda: image_of(np.ones((4, 4, 4)) / 3, float), {}, InvalidMeshError, "integers"),
        (lambda: image_of(meshes.grains(6, 2)), {"labels": "9"}, ParameterError, "no label 9; it has 1, 2"),
        (lambda: image_of(meshes.grains(6, 2)), {"labels": "one"}, ParameterError, "1,3,5-9"),
        (lambda: image_of(meshes.grains(6, 2)), {"scalars": "no"}, ParameterError, "tissue"),
        (lambda: pv.ImageData(dimensions=(3, 3, 3)), {}, ParameterError, "no arrays"),
        (lambda: pv.Sphere(), {}, InvalidMeshError, "must be vtkImageData"),
    ],
)
def test_what_is_no_label_image_is_refused(image, parameters, error, message):
    with pytest.raises(error, match=message):
        SegmentationSurface(**parameters)(image())


def _write(image, path):
    from vtkmodules.vtkIOImage import vtkMetaImageWriter, vtkNIFTIImageWriter, vtkTIFFWriter

    if path.suffix == ".vti":
        image.save(path)
        return
    if path.suffix == ".nrrd":
        sizes = " ".join(map(str, image.dimensions))
        head = (
            f"NRRD0004\n# as Slicer does\ntype: unsigned char\ndimension: 3\nsizes: {sizes}\nencoding: gzip\n"
        )
        place = "space directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (5,6,7)\nspace:=lps\n\n"
        path.write_bytes((head + place).encode() + gzip.compress(np.asarray(image["tissue"]).tobytes()))
        return
    writer = {
        ".mha": vtkMetaImageWriter,
        ".nii": vtkNIFTIImageWriter,
        ".gz": vtkNIFTIImageWriter,
        ".tif": vtkTIFFWriter,
    }
    one = writer[path.suffix]()
    one.SetFileName(str(path))
    one.SetInputData(image)
    one.Write()


@pytest.mark.parametrize("extension", ["vti", "nrrd", "nii", "nii.gz", "mha", "tif"])
def test_the_command_reads_what_people_have(extension, tmp_path, capsys):
    voxels = meshes.grains(9, 3)
    image = image_of(voxels, spacing=(1.0, 1.0, 2.0))
    image.set_active_scalars("tissue")
    source, target = tmp_path / f"labels.{extension}", tmp_path / "out.vtp"
    _write(image, source)
    assert main(["segmentation", str(source), str(target), "--iterations", "3", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    spacing = 1.0 if extension == "tif" else 2.0  # TIFF has none
    for each in figures["labels"]:
        assert each["volume"] == pytest.approx(spacing * (voxels == each["label"]).sum(), rel=1e-12)
    surface = pv.read(target)
    assert np.unique(sides_of(surface)).tolist() == [0, 1, 2, 3]
    assert surface.points.dtype == np.float64


def test_the_command_writes_a_file_for_each_label(tmp_path, capsys):
    image_of(meshes.grains(9, 3)).save(tmp_path / "labels.vti")
    arguments = ["segmentation", str(tmp_path / "labels.vti"), str(tmp_path / "part.stl")]
    assert main([*arguments, "--separate", "--iterations", "2"]) == 0
    assert sorted(path.name for path in tmp_path.glob("*.stl")) == ["part_1.stl", "part_2.stl", "part_3.stl"]
    assert "volume before" in capsys.readouterr().out


def test_a_nifti_file_says_where_it_is(tmp_path):
    from vtkmodules.vtkCommonMath import vtkMatrix4x4
    from vtkmodules.vtkIOImage import vtkNIFTIImageWriter

    image = image_of(meshes.grains(7, 2))
    image.set_active_scalars("tissue")
    placed = vtkMatrix4x4()
    for i, row in enumerate([[0, -1, 0, 10], [1, 0, 0, 20], [0, 0, 1, 30]]):
        for j, value in enumerate(row):
            placed.SetElement(i, j, value)
    writer = vtkNIFTIImageWriter()
    writer.SetQFac(1)
    writer.SetQFormMatrix(placed)
    writer.SetFileName(str(tmp_path / "labels.nii"))
    writer.SetInputData(image)
    writer.Write()
    read, notes = read_image(tmp_path / "labels.nii")
    assert notes == []
    assert np.allclose(read.GetOrigin(), (10, 20, 30))
    assert read.GetDirectionMatrix().GetElement(0, 1) == pytest.approx(-1)
    values = vtk_to_numpy(read.GetPointData().GetScalars())
    np.testing.assert_array_equal(values, image["tissue"])


@pytest.mark.parametrize("name", ["labels.xyz", "labels.vti", "labels.nrrd", "empty.mha"])
def test_files_that_are_no_images_are_refused(name, tmp_path):
    (tmp_path / name).write_bytes(b"" if name.startswith("empty") else b"no image at all")
    with pytest.raises(MeshFileError):
        read_image(tmp_path / name)
    with pytest.raises(MeshFileError, match="check the path"):
        read_image(tmp_path / "missing.vti")
