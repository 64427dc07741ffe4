"""What all filters share: declared parameters, errors, progress, abort, composite data, pass-through."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from os import PathLike
from typing import Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringArray
from vtkmodules.vtkCommonDataModel import (
    vtkCompositeDataSet,
    vtkDataObject,
    vtkDataSet,
    vtkPolyData,
)
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm

from ..errors import Cancelled, InvalidMeshError, ParameterError, VtksmoothError
from ..jit.compile_ahead import compiling_ahead
from ..other_names import OTHER_NAMES, advice, advice_for_method, snake
from . import interruption
from .arrays import points_of, vtk_array
from .normals import renew
from .parameter import Parameter, add_vtk_access, documentation, parameters_of
from .places import DUPLICATES, HIDDEN, Block, Joined, Merge, joined, named

#: Least time between two progress events, seconds: observers repaint windows.
_PROGRESS_INTERVAL = 0.02


class Input(NamedTuple):
    """What an input is: in two words at most, in a sentence, and whether it has the points of the first."""

    title: str
    description: str
    same_points: bool = False


#: The inputs that filters have, by their names.
INPUTS = {
    "mesh": Input("mesh", "The mesh."),
    "result": Input("result", "The mesh as it is now."),
    "original": Input("original", "The mesh from before, with the same points and faces.", True),
    "installation": Input("installation space", "The installation space, its normals outwards."),
    "source": Input(
        "source surface", "A surface that points are put and kept on, such as a CAD tessellation or a scan."
    ),
    "image": Input("label image", "The image of labels."),
}


class Filter(VTKPythonAlgorithmBase):
    """A VTK filter on polydata, and on composite datasets of polydata.

    Subclasses declare parameters and implement :meth:`execute`. A filter may be called like a function:
    ``result = filter(mesh)``.

    Attributes
    ----------
    last_error : BaseException or None
        What ended the last execution. :meth:`Update` raises it; so does calling the filter.
    summary : dict
        What the last execution measured or did; empty before the first and after one that failed.
    notes : list of str
        What else people should know of the last execution.
    """

    last_error: BaseException | None = None
    summary: dict[str, Any]
    notes: list[str]
    #: The surface that :meth:`execute` sees, if that is not the input as it is.
    whole: Joined | None

    #: Name on the command line and in reports.
    command: ClassVar[str] = ""
    #: Names of the inputs that it needs, keys of ``INPUTS``.
    inputs: ClassVar[tuple[str, ...]] = ("mesh",)
    #: Names of the inputs that may be missing, on the ports after those.
    optional_inputs: ClassVar[tuple[str, ...]] = ()
    #: The types of VTK that the inputs may be of.
    accepts: ClassVar[tuple[type, ...]] = (vtkPolyData, vtkCompositeDataSet)
    #: Names of the outputs.
    outputs: ClassVar[tuple[str, ...]] = ("mesh",)
    #: Whether the filter only measures: then the command line prints `summary` and writes no mesh.
    measures: ClassVar[bool] = False
    #: Names of the inputs in the command line's order, where that is another one.
    arguments: ClassVar[tuple[str, ...]] = ()
    #: Whether :meth:`execute` sees no faces without area, and of faces that cover each other only one, where
    #: points in one place have become one.
    clean: ClassVar[bool] = False
    #: Bits of ``vtkGhostType`` of the cells that :meth:`execute` does not see.
    skipped: ClassVar[int] = DUPLICATES | HIDDEN
    #: What becomes of points in one place, for a note.
    says_of_places: ClassVar[str] = "points in one place count as one."

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        add_vtk_access(cls)
        if cls.command and parameters_of(cls):
            before, heading, rest = (cls.__doc__ or "").partition("    Guarantees\n")
            lines = documentation(cls).replace("\n", "\n    ")
            cls.__doc__ = f"{before.rstrip()}\n\n    {lines}\n\n{heading}{rest}"

    def __init__(self, **parameters: Any) -> None:
        super().__init__(
            nInputPorts=len(self.every_input()),
            inputType="vtkPolyData",
            nOutputPorts=len(self.outputs),
            outputType="vtkDataObject",
        )
        self.forget()
        self._will_raise = False
        self._told = 0.0
        self._share = (0.0, 1.0)
        for name, value in parameters.items():
            if name not in self.parameters():
                instead = advice(name, self.parameters())
                instead = instead or f"it has: {', '.join(self.parameters()) or 'none'}"
                raise ParameterError(f"{type(self).__name__} has no parameter {name!r}; {instead}.")
            setattr(self, name, value)

    def __setattr__(self, name: str, value: Any) -> None:
        # VTK's objects take any attribute; a parameter by its name in VTK or PyVista must not be lost in one.
        if snake(name) in OTHER_NAMES and (instead := advice(name, self.parameters())):
            raise AttributeError(f"{type(self).__name__} has no parameter {name!r}; {instead}.")
        super().__setattr__(name, value)

    def __getattr__(self, name: str) -> Any:
        """Raise AttributeError; name our parameter in place of one of VTK or PyVista."""
        known = self.parameters()
        instead = advice_for_method(name, known) or advice(name, known)
        raise AttributeError(
            f"{type(self).__name__} has no attribute {name!r}{instead and f'; {instead}'}.",
            name=name, obj=self,
        )  # fmt: skip

    @classmethod
    def parameters(cls) -> dict[str, Parameter]:
        """Return the declared parameters by name, in order."""
        return parameters_of(cls)

    @classmethod
    def every_input(cls) -> tuple[str, ...]:
        """Return the names of all inputs, port by port."""
        return cls.inputs + cls.optional_inputs

    @property
    def figures(self) -> dict[str, Any]:
        """What the last execution measured or did, as the command line's ``--json`` shows it."""
        return self.summary

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={getattr(self, name)!r}" for name in self.parameters())
        return f"{type(self).__name__}({values})"

    # -- what subclasses do ------------------------------------------------------------------------

    def execute(self, *inputs: Any) -> Any:
        """Return the output for vtkPolyData `inputs`, which must not be changed.

        A vtkPolyData; with several outputs a tuple of them. Optional inputs that are missing are left out.
        Where points of the input coincide, or it is in blocks or has ghost cells, the first of `inputs` is
        one surface made of it, see `whole`.
        """
        raise NotImplementedError

    def forget(self) -> None:
        """Drop what the last execution reported: a run that fails must not show figures of the one before."""
        self.summary, self.notes, self.whole = {}, [], None

    def check(self, *inputs: Any) -> None:
        """Raise what is wrong with one block of the inputs."""

    def prepared(self, block: Block) -> Any:
        """Return the vtkPolyData to work on in place of a block, with the same points."""
        return block.data

    def merges(self) -> dict[str, Merge]:
        """Return what becomes of point arrays where several points are one."""
        return {}

    def points_given(self, source: Any) -> int:
        """Return how many points the input has, of which `source` is what :meth:`execute` sees."""
        return source.GetNumberOfPoints() if self.whole is None else int(self.whole.counted.sum())

    def copies(self, source: Any) -> npt.NDArray[np.int64]:
        """Return how many points of the input each point of what :meth:`execute` sees is, (n,)."""
        return np.ones(source.GetNumberOfPoints(), np.int64) if self.whole is None else self.whole.copies()

    def joins_all(self, block: Any) -> bool:
        """Return whether all points in one place become one, whatever faces of the block meet there."""
        return False

    def edge_arrays(self) -> list[str]:
        """Return the names of field arrays that hold pairs of points."""
        return []

    def spread(self, results: tuple[Any, ...], whole: Joined) -> list[tuple[Any, ...]]:
        """Return the outputs for each block, of those for the whole surface."""
        return [(output,) for output in whole.spread(results[0], keep_precision=True)]

    def progress(self, fraction: float, what: str = "") -> None:
        """Report progress (0 to 1) to VTK's observers.

        Raises
        ------
        Cancelled
            The filter has been asked to abort, or the program ends.
        KeyboardInterrupt
            Ctrl-C was pressed, and the filter runs in the main thread.
        """
        interruption.check()
        if self.GetAbortExecute() or self.CheckAbort():
            raise Cancelled(f"{type(self).__name__} was cancelled.")
        now = time.monotonic()
        if now - self._told >= _PROGRESS_INTERVAL or fraction in (0.0, 1.0):
            self._told = now
            low, high = self._share
            if what:
                self.SetProgressText(what)
            self.UpdateProgress(low + fraction * (high - low))
            if self.GetAbortExecute():
                raise Cancelled(f"{type(self).__name__} was cancelled.")

    # -- calling from Python -----------------------------------------------------------------------

    def __call__(self, *inputs: Any) -> Any:
        """Run on `inputs` (vtkPolyData, pyvista.PolyData or composite) and return the output.

        Optional inputs that are left out are none, whatever was connected before. A filter with several
        outputs returns a tuple of them. What is returned is the caller's: the next run does not touch it.

        Raises
        ------
        InvalidMeshError
            An input is missing, of another type, or cannot be worked on.
        ParameterError, Cancelled, KeyboardInterrupt
            What else ended the run.
        TypeError
            The number of inputs is wrong.
        """
        every = self.every_input()
        if not len(self.inputs) <= len(inputs) <= len(every):
            optional = "".join(f"; {name} may be left out" for name in self.optional_inputs)
            raise TypeError(f"{type(self).__name__} takes {len(every)} inputs: {', '.join(every)}{optional}.")
        try:
            for port in range(len(every)):
                self.SetInputDataObject(port, inputs[port] if port < len(inputs) else None)
            self.Update()
            if self.last_error is not None:
                raise self.last_error
        except BaseException:
            self.forget()
            raise
        finally:
            # VTK's abort flag sticks; the next call is another run.
            self.SetAbortExecute(0)
        outputs = tuple(_shared(self.GetOutputDataObject(port)) for port in range(len(self.outputs)))
        return outputs if len(outputs) > 1 else outputs[0]

    def Update(self, *arguments: Any) -> Any:
        """Bring the output up to date, as in VTK; raise what went wrong, also in filters of ours before this.

        An abort is no error here, as in VTK: the output is empty and `last_error` tells.
        """
        return self._run(super().Update, *arguments)

    def UpdatePiece(self, *arguments: Any) -> Any:
        """Bring a piece of the output up to date, as :meth:`Update` does the whole."""
        return self._run(super().UpdatePiece, *arguments)

    def UpdateExtent(self, *arguments: Any) -> Any:
        """Bring an extent of the output up to date, as :meth:`Update` does the whole."""
        return self._run(super().UpdateExtent, *arguments)

    def UpdateTimeStep(self, *arguments: Any) -> Any:
        """Bring the output up to date for a time, as :meth:`Update` does."""
        return self._run(super().UpdateTimeStep, *arguments)

    def UpdateWholeExtent(self) -> Any:
        """Bring the output up to date, as :meth:`Update` does."""
        return self._run(super().UpdateWholeExtent)

    def _run(self, update: Callable[..., Any], *arguments: Any) -> Any:
        chain = list(_filters_up_to(self))
        for algorithm in chain:
            if algorithm.last_error is not None:
                # To VTK the empty output of a run that failed is up to date.
                algorithm.last_error = None
                algorithm.Modified()
        self._will_raise = True
        try:
            with interruption.running(called_by_vtk=False):
                result = update(*arguments)
        except BaseException as error:
            self.last_error = error
            self.forget()
            raise
        finally:
            self._will_raise = False
        failure = next((each.last_error for each in chain if each.last_error is not None), None)
        if failure is None and result is False:
            failure = InvalidMeshError(
                f"{type(self).__name__} did not run, for reasons that VTK has logged; check its inputs."
            )
        if failure is not None:
            self.last_error = failure
            self.forget()
            if not isinstance(failure, Cancelled):
                raise failure
        return result

    def SetInputDataObject(self, *arguments: Any) -> None:
        """Set the data of input 0, or with two arguments of the input named first.

        Raises
        ------
        InvalidMeshError
            What is given is no data object of VTK.
        """
        port, data = arguments if len(arguments) == 2 else (0, *arguments)
        if data is not None and not isinstance(data, vtkDataObject):
            raise self._wrong_input(port, data)
        super().SetInputDataObject(port, data)

    def SetInputData(self, *arguments: Any) -> None:
        """Set the data of input 0, or with two arguments of the input named first."""
        self.SetInputDataObject(*arguments)

    def GetOutput(self, port: int = 0) -> Any:
        """Return the output of the last execution."""
        return self.GetOutputDataObject(port)

    # -- VTK's side --------------------------------------------------------------------------------

    def FillInputPortInformation(self, port: int, info: Any) -> int:
        """Accept everything, and nothing.

        :meth:`RequestData` refuses what is neither polydata nor a composite dataset of it: VTK would only log
        it and leave the output empty.
        """
        info.Set(vtkAlgorithm.INPUT_REQUIRED_DATA_TYPE(), "vtkDataObject")
        info.Set(vtkAlgorithm.INPUT_IS_OPTIONAL(), 1)
        return 1

    def RequestDataObject(self, request: Any, inInfo: Any, outInfo: Any) -> int:
        """Make the outputs of the type of the first input."""
        source = vtkDataObject.GetData(inInfo[0], 0)
        kind = _vtk_class(source) if isinstance(source, vtkCompositeDataSet) else vtkPolyData
        for port in range(len(self.outputs)):
            output = vtkDataObject.GetData(outInfo, port)
            if output is None or not output.IsA(kind.__name__):
                outInfo.GetInformationObject(port).Set(vtkDataObject.DATA_OBJECT(), kind())
        return 1

    def RequestData(self, request: Any, inInfo: Any, outInfo: Any) -> int:
        """Run :meth:`execute` and turn exceptions into VTK errors."""
        outputs = [vtkDataObject.GetData(outInfo, port) for port in range(len(self.outputs))]
        self.last_error = None
        self.forget()
        try:
            with interruption.running(called_by_vtk=True), compiling_ahead(type(self).__name__):
                sources = [vtkDataObject.GetData(inInfo[port], 0) for port in range(len(self.every_input()))]
                for port, source in enumerate(sources):
                    left_out = source is None and port >= len(self.inputs)
                    if not (left_out or isinstance(source, self.accepts)):
                        raise self._wrong_input(port, source)
                self._refuse_what_is_not_read()
                self._execute_all(sources, outputs)
        except (Cancelled, KeyboardInterrupt) as interrupted:
            self.last_error = interrupted
        except VtksmoothError as error:
            self.last_error = error
            self._say(f"{type(self).__name__}: {error}")
        except BaseException as error:
            # A defect of ours must not look like success on VTK's side either, and C++ drops all exceptions.
            self.last_error = error
            self._say(f"{type(self).__name__} failed: {type(error).__name__}: {error}")
        if self.last_error is None:
            return 1
        self.forget()
        for output in outputs:
            output.Initialize()
        self.SetAbortOutput(True)
        # "Failure" makes the executive print that a request failed. That is for those who pull on this
        # filter from downstream: an abort is none, and Update() is about to raise the exception itself.
        return int(self._will_raise or isinstance(self.last_error, Cancelled))

    def _refuse_what_is_not_read(self) -> None:
        for name, parameter in self.parameters().items():
            value = getattr(self, name)
            if value != parameter.default and not parameter.has_say(self._given):
                now = ", ".join(f"{other}={self._given(other)!r}" for other in parameter.only)
                raise ParameterError(
                    f"{name}={value!r} has no effect with {now}: leave it out; it has one where "
                    f"{parameter.where}."
                )

    def _given(self, name: str) -> Any:
        """Return the value of a parameter, or what is connected to an input."""
        every = self.every_input()
        return self.GetInputDataObject(every.index(name), 0) if name in every else getattr(self, name)

    def _wrong_input(self, port: int, data: Any) -> InvalidMeshError:
        title = INPUTS[self.every_input()[port]].title
        if vtkPolyData not in self.accepts:
            given = "nothing" if data is None else type(data).__name__
            names = " or ".join(each.__name__ for each in self.accepts)
            return InvalidMeshError(f"The {title} must be {names}, not {given}; read it with pyvista.read().")
        if data is None:
            return InvalidMeshError(f"The {title} is missing; give polydata as input {port + 1}.")
        remedy = "give a surface mesh"
        if isinstance(data, vtkDataSet):
            remedy = "extract its surface first, with vtkGeometryFilter or PyVista's extract_surface()"
        elif isinstance(data, (str, PathLike)):
            remedy = "read the file first, with pyvista.read()"
        return InvalidMeshError(f"The {title} must be polydata, not {type(data).__name__}; {remedy}.")

    def _execute_all(self, sources: list[Any], outputs: list[Any]) -> None:
        self._share, self.notes = (0.0, 1.0), []
        main, *others = sources
        if not isinstance(main, vtkCompositeDataSet):
            for number, (name, source) in enumerate(zip(self.every_input()[1:], others, strict=True), 2):
                if INPUTS[name].same_points and isinstance(source, vtkCompositeDataSet):
                    raise InvalidMeshError(
                        f"Input {number} is composite and input 1 is not; merge its blocks into one polydata."
                    )
            results = self._execute_blocks([Block(None, main)], [others])[0]
            for output, result in zip(outputs, results, strict=True):
                output.ShallowCopy(result)
            return
        blocks, seconds = self._blocks(main, others)
        every = self._execute_blocks(blocks, seconds) if blocks else []
        made = {block.index: result for block, result in zip(blocks, every, strict=True)}
        for output in outputs:
            output.CopyStructure(main)
        for leaf in _leaves(main):
            # Pieces without faces are usual in composite data.
            nothing = (leaf.GetCurrentDataObject(), *(vtkPolyData() for _ in self.outputs[1:]))
            for output, result in zip(outputs, made.get(leaf.GetCurrentFlatIndex(), nothing), strict=True):
                output.SetDataSet(leaf, result)

    def _blocks(self, main: Any, others: list[Any]) -> tuple[list[Block], list[list[Any]]]:
        """Return the blocks that have faces, and the further inputs of each."""
        blocks, seconds = [], []
        for leaf in _leaves(main):
            index = leaf.GetCurrentFlatIndex()
            data = [leaf.GetCurrentDataObject()]
            for name, source in zip(self.every_input()[1:], others, strict=True):
                # One that is no composite belongs to every block; so does an installation space in blocks.
                paired = isinstance(source, vtkCompositeDataSet) and INPUTS[name].same_points
                data.append(source.GetDataSet(leaf) if paired else source)
            given = [one for one, source in zip(data, [main, *others], strict=True) if source is not None]
            if not all(isinstance(one, vtkPolyData | vtkCompositeDataSet) for one in given):
                names = ", ".join("nothing" if one is None else _vtk_class(one).__name__ for one in given)
                raise InvalidMeshError(
                    f"Block {index} must be polydata, not {names}; extract its surface first."
                )
            if data[0].GetNumberOfPolys() + data[0].GetNumberOfStrips():
                blocks.append(Block(index, data[0]))
                seconds.append(data[1:])
        return blocks, seconds

    def _execute_blocks(self, blocks: list[Block], seconds: list[list[Any]]) -> list[tuple[Any, ...]]:
        """Run :meth:`execute` on blocks as one surface; return the outputs for each of them."""
        for block, others in zip(blocks, seconds, strict=True):
            with named(block):
                self.check(block.data, *others)
        before = [Block(block.index, self.prepared(block)) for block in blocks]
        paired = [INPUTS[name].same_points for name in self.every_input()[1:]]
        same = [[other for other, pair in zip(others, paired, strict=True) if pair] for others in seconds]
        clean = self.clean and not any(self.joins_all(block.data) for block in before)
        has_faces = before[0].data.GetNumberOfPolys() + before[0].data.GetNumberOfStrips() > 0
        self.whole = whole = (
            joined(before, [others[0] for others in same] if any(paired) else None, clean, self.skipped)
            if has_faces
            else None
        )
        further = [
            whole.like([others[place] for others in seconds])
            if pair and whole is not None
            else _one_surface(seconds[0][place], INPUTS[self.every_input()[1 + place]].title)
            for place, pair in enumerate(paired)
        ]
        if whole is not None:
            whole.take_arrays(self.merges(), self.edge_arrays())
        while further and further[-1] is None:
            further.pop()
        result = self.execute(before[0].data if whole is None else whole.polydata, *further)
        self.whole = None
        result = result if isinstance(result, tuple) else (result,)
        results = [result] if whole is None else self.spread(result, whole)
        if whole is not None and whole.merged_points:
            self.notes.insert(
                0, f"{whole.merged_points} points lie where another one is: {self.says_of_places}"
            )
        after = [outputs[0] for outputs in results]
        if any(_reshaped(old.data, new) for old, new in zip(before, after, strict=True)):
            place = whole.place if whole is not None and whole.merged_points else None
            self.notes += renew([block.data for block in before], after, place)
        return results

    def _say(self, message: str) -> None:
        if self.HasObserver("ErrorEvent"):
            self.InvokeEvent("ErrorEvent", message)
        elif not self._will_raise:
            vtkOutputWindow.GetInstance().DisplayErrorText(message + "\n")


def _leaves(composite: Any) -> Iterator[Any]:
    """Go through the blocks of composite data that are there."""
    leaves = composite.NewIterator()
    leaves.InitTraversal()
    while not leaves.IsDoneWithTraversal():
        yield leaves
        leaves.GoToNextItem()


def _one_surface(source: Any, title: str) -> Any:
    """Return an input in blocks as one polydata; one that is in one piece as it is.

    Errors call it by its `title`.
    """
    if not isinstance(source, vtkCompositeDataSet):
        return source
    blocks = []
    for leaf in _leaves(source):
        data, index = leaf.GetCurrentDataObject(), leaf.GetCurrentFlatIndex()
        if not isinstance(data, vtkPolyData):
            raise InvalidMeshError(
                f"Block {index} of the {title} must be polydata, not {_vtk_class(data).__name__}; extract "
                "its surface first."
            )
        if data.GetNumberOfPolys() + data.GetNumberOfStrips():
            blocks.append(Block(index, data))
    if not blocks:
        raise InvalidMeshError(f"The {title} has no faces in any block; give a surface of polygons.")
    whole = joined(blocks, None, False, DUPLICATES | HIDDEN)
    return blocks[0].data if whole is None else whole.polydata


def _reshaped(before: Any, after: Any) -> bool:
    """Return whether a filter has moved points or changed faces."""
    return before.GetPolys() is not after.GetPolys() or (
        before.GetPoints() is not after.GetPoints()
        and not np.array_equal(points_of(before), points_of(after), equal_nan=True)
    )


def _vtk_class(data: Any) -> Any:
    # Objects may be of a Python subclass (pyvista.PolyData) whose name VTK does not know.
    return next(base for base in type(data).__mro__ if base.__module__.startswith("vtkmodules."))


def _shared(output: Any) -> Any:
    """Return a new data object that shares everything with `output`, which VTK reuses in each run."""
    result = output.NewInstance()
    result.ShallowCopy(output)
    return result


def _filters_up_to(algorithm: Any) -> Iterator[Filter]:
    """Yield the filters of ours that `algorithm` depends on, those at the beginning first, and itself."""
    for port in range(algorithm.GetNumberOfInputPorts()):
        for number in range(algorithm.GetNumberOfInputConnections(port)):
            yield from _filters_up_to(algorithm.GetInputConnection(port, number).GetProducer())
    if isinstance(algorithm, Filter):
        yield algorithm


def add_field(output: vtkPolyData, name: str, value: npt.ArrayLike | str) -> None:
    """Add numbers or a text to the field data of `output`."""
    if isinstance(value, str):
        text = vtkStringArray()
        text.SetName(name)
        text.InsertNextValue(value)
        output.GetFieldData().AddArray(text)
    else:
        output.GetFieldData().AddArray(vtk_array(np.atleast_1d(np.asarray(value)), name))
