"""What a run did, for people and for field data."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

#: Why a run ended.
STOP_REASONS = {
    "iterations": "all iterations were done",
    "converged": "no vertex could be improved any more",
    "nothing-to-do": "no vertex is free to move",
    "gate": "the gate accepts no step of any vertex; with another gate, or none, the surface would change",
    "gain": "the mean quality grew by less than stop_gain in an iteration",
    "normal-deviation": "the next iteration would exceed stop_normal_deviation",
    "dihedral-change": "the next iteration would exceed stop_dihedral_change",
    "deviation": "the next iteration would exceed stop_deviation_fraction",
    "volume": "the next iteration would exceed stop_volume_percent",
    "white": "what was removed has become white: there is no more noise to remove",
    "target": "every vertex is where the scheme puts it, as far as it may go",
    "pass-band": "the next iteration would amplify frequencies below pass_band by more than 1.5 %; "
    "lower pass_band to smooth more",
}


def figure(value: float, digits: int = 4, sign: str = "") -> str:
    """Return a number in at least so many significant digits, without an exponent from 1e-4 to 1e6.

    Integers are shown as they are.

    Examples
    --------
    >>> figure(-100.0, 2, "+"), figure(123456.7), figure(0.0001, 2), figure(2.5e7)
    ('-100', '123457', '0.0001', '2.5e+07')
    """
    if isinstance(value, int):
        return f"{value:{sign}d}"
    text = f"{value:{sign}.{digits}g}"
    return f"{value:{sign}.0f}" if "e+" in text and abs(value) < 1e6 else text


@dataclass
class RunReport:
    """What a smoothing run did.

    Attributes
    ----------
    iterations : int
        Iterations carried out (and kept).
    stop_reason : str
        A key of :data:`STOP_REASONS`.
    moved : int
        Vertices that are elsewhere than at the start.
    seconds : float
        Time of the run.
    mean_aspect_ratio, min_aspect_ratio : tuple of float
        k before and after, against the directions of the input.
    inverted : tuple of int
        Faces with k < 0 before and after, against the directions of the input.
    volume : tuple of float, or None
        Before and after; None for open meshes.
    volume_rounded : float or None
        The volume after rounding to the precision of the output's points; None for open meshes.
    swept_volume : float
        Volume between the surfaces before and after; for closed meshes the change of the volume.
    flux : float or None
        Volume that the surface was to gain by the parameter `flux`, beside what it did, `swept_volume`.
    volume_residuals : tuple of float
        With corrections of the local volume, the largest residual before each of the last pass and at its
        end: volume swept round a vertex, over its part of the area; model units.
    volume_shortened : int
        Passes in which steps were shortened, or not taken, because the volume could not be kept otherwise.
    taken_back : int
        Vertices whose steps were taken back in part or wholly, as faces would have crossed or touched; summed
        over all looks.
    broken : list of str
        Promises of constraints that do not hold, where the run was asked to check; always empty, unless
        something is wrong with the program.
    merged_points : int
        Points of the input that lie where another one is: points in one place are one vertex.
    irregular : int
        Vertices held because edges there are non-manifold or disagree on the orientation.
    vertex_classes : tuple of int
        Vertices that are smooth, on ridges, corners and cusps, where features are kept; empty elsewhere.
    wavelength : float or None
        Of the scheme low-pass, the wavelength of which half is left; model units.
    curvature_radius : float or None
        Points as flat as a sphere of this radius did not move; None without a bound.
    noise_level : float or None
        Standard deviation of the noise across the surface at the start, model units, of denoising.
    on_source : tuple of int
        With a source, vertices kept on its surface, on its ridges, and on its corners.
    source_deviation : tuple of float, or None
        With a source, the largest distance of any vertex from it before and after, fixed ones too.
    moves_checked, distances_asked : int
        Moves held against an installation space, and those of them for which a distance had to be computed.
    label_volumes : tuple of (int, float, float)
        Of surfaces between labels each label's value, and its volume before and after. What is outside of all
        has the volume of all others, negative.
    """

    iterations: int = 0
    stop_reason: str = "iterations"
    moved: int = 0
    seconds: float = 0.0
    mean_aspect_ratio: tuple[float, float] = (0.0, 0.0)
    min_aspect_ratio: tuple[float, float] = (0.0, 0.0)
    inverted: tuple[int, int] = (0, 0)
    volume: tuple[float, float] | None = None
    volume_rounded: float | None = None
    swept_volume: float = 0.0
    flux: float | None = None
    volume_residuals: tuple[float, ...] = ()
    volume_shortened: int = 0
    taken_back: int = 0
    broken: list[str] = field(default_factory=list)
    merged_points: int = 0
    irregular: int = 0
    vertex_classes: tuple[int, ...] = ()
    wavelength: float | None = None
    curvature_radius: float | None = None
    noise_level: float | None = None
    on_source: tuple[int, ...] = ()
    source_deviation: tuple[float, float] | None = None
    moves_checked: int = 0
    distances_asked: int = 0
    label_volumes: tuple[tuple[int, float, float], ...] = ()

    @property
    def worst_label(self) -> tuple[float, int]:
        """The largest change of a label's volume, as a part of it, and the label."""
        changes = [
            (abs(after / before - 1.0), label) for label, before, after in self.label_volumes if before
        ]
        return max(changes, default=(0.0, 0))

    def _volume(self) -> str:
        if self.label_volumes:
            largest, label = self.worst_label
            return f"volumes of {len(self.label_volumes)} labels within {largest:.2g} (label {label})"
        if self.volume is None:
            return f"volume swept {figure(self.swept_volume, 3)}"
        before, after = self.volume
        change = f" ({figure(100.0 * (after / before - 1.0), 2, '+')} %)" if before else ""
        return f"volume {figure(before, 6)} -> {figure(after, 6)}{change}"

    def _taken_back(self) -> str:
        if not self.taken_back:
            return ""
        return f"{self.taken_back} steps taken back where faces would have crossed; "

    def _cusps(self) -> str:
        cusps = self.vertex_classes[-1] if self.vertex_classes else 0
        return f"{cusps} cusp{'s'[: cusps != 1]} held; " if cusps else ""

    def _chosen(self) -> str:
        """Return what the mesh, or somebody, has chosen of the scheme."""
        noise = "" if self.noise_level is None else f"noise level {figure(self.noise_level, 3)}; "
        return noise if self.wavelength is None else f"{noise}wavelength {figure(self.wavelength, 3)}; "

    def _source(self) -> str:
        if self.source_deviation is None:
            return ""
        before, after = self.source_deviation
        return f"distance from the source at most {figure(before, 3)} -> {figure(after, 3)}; "

    def __str__(self) -> str:
        reason = STOP_REASONS[self.stop_reason]
        return (
            f"{self.iterations} iterations, {self.moved} vertices moved, {self.seconds:.2f} s; "
            f"k mean {self.mean_aspect_ratio[0]:.3f} -> {self.mean_aspect_ratio[1]:.3f}, "
            f"min {self.min_aspect_ratio[0]:.3f} -> {self.min_aspect_ratio[1]:.3f}, "
            f"inverted {self.inverted[0]} -> {self.inverted[1]}; {self._volume()}; "
            f"{self._chosen()}{self._cusps()}{self._source()}{self._taken_back()}stopped because {reason}."
        )


@dataclass
class InstallationSpaceReport(RunReport):
    """What smoothing inside an installation space did.

    Attributes
    ----------
    fixed, blended, free : int
        Points on the space's surface that stay, those of them that move a little, and the others.
    outside, crossing : tuple of int
        Points outside the space and triangles that cross its surface, before and after, the latter as
        the output's precision has it.
    notes : list of str
        What a user should know about the installation space.
    """

    fixed: int = 0
    blended: int = 0
    free: int = 0
    outside: tuple[int, int] = (0, 0)
    crossing: tuple[int, int] = (0, 0)
    notes: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        written = "" if self.volume_rounded is None else f"; volume as written {self.volume_rounded:.17g}"
        lines = [
            super().__str__(),
            f"{self.free} points free, {self.blended} blended, {self.fixed} on the space{written}",
            f"outside {self.outside[0]} -> {self.outside[1]} points, crossing {self.crossing[0]} -> "
            f"{self.crossing[1]} triangles",
            *self.notes,
        ]
        return "\n".join(lines)


@dataclass(frozen=True)
class LabelVolume:
    """What has become of one label.

    Attributes
    ----------
    label : int
    voxels : int
        How many voxels have it.
    volume_before, volume : float
        Volume that its surface encloses before and after smoothing.
    """

    label: int
    voxels: int
    volume_before: float
    volume: float

    @property
    def change(self) -> float:
        """Change of the volume, as a part of it."""
        return self.volume / self.volume_before - 1.0 if self.volume_before else 0.0


@dataclass
class SegmentationReport(RunReport):
    """What became of a label image.

    Attributes
    ----------
    labels : list of LabelVolume
        All labels but the background.
    voxel_volume : float
    """

    labels: list[LabelVolume] = field(default_factory=list)
    voxel_volume: float = 0.0

    def figures(self) -> dict[str, Any]:
        """Return the report as a dictionary."""
        figures = asdict(self)
        figures["labels"] = [asdict(each) | {"change": each.change} for each in self.labels]
        return figures

    def __str__(self) -> str:
        rows = [
            f"{each.label:>12d}{each.voxels:>12d}{each.volume_before:>16.8g}{each.volume:>16.8g}{each.change:>12.1e}"
            for each in self.labels
        ]
        head = f"{'label':>12}{'voxels':>12}{'volume before':>16}{'volume':>16}{'change':>12}"
        return "\n".join([super().__str__(), head, *rows])
