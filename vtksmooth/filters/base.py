"""What all filters share: declared parameters, errors, progress, abort, composite data, pass-through."""

from __future__ import annotations

import time
from typing import Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringArray
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet, vtkDataObject, vtkFieldData, vtkPolyData
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm

from ..errors import Cancelled, InvalidMeshError, ParameterError, VtksmoothError
from ..kernels.compile_ahead import compiling_ahead
from .arrays import vtk_array
from .parameter import Parameter, add_vtk_access, documentation, parameters_of

#: Least time between two progress events, seconds: observers repaint windows.
_PROGRESS_INTERVAL = 0.02


class Input(NamedTuple):
    """What an input is: in two words at most, and in a sentence."""

    title: str
    description: str


#: The inputs that filters have, by their names.
INPUTS = {
    "mesh": Input("mesh", "The mesh."),
    "result": Input("result", "The mesh as it is now."),
    "original": Input("original", "The mesh from before, with the same points and faces."),
    "installation": Input("installation space", "The installation space, its normals outwards."),
}


class Filter(VTKPythonAlgorithmBase):
    """A VTK filter on polydata, and on composite datasets of polydata.

    Subclasses declare parameters and implement :meth:`execute`. A filter may be called like a function:
    ``result = filter(mesh)``.

    Attributes
    ----------
    last_error : Exception or None
        What ended the last execution. :meth:`Update` raises it; so does calling the filter.
    """

    #: Name on the command line and in reports.
    command: ClassVar[str] = ""
    #: Names of the inputs, keys of ``INPUTS``.
    inputs: ClassVar[tuple[str, ...]] = ("mesh",)
    #: Names of the outputs.
    outputs: ClassVar[tuple[str, ...]] = ("mesh",)
    #: Whether the filter only measures: then the command line prints `summary` and writes no mesh.
    measures: ClassVar[bool] = False
    #: Names of the inputs in the command line's order, where that is another one.
    arguments: ClassVar[tuple[str, ...]] = ()

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        add_vtk_access(cls)
        if cls.command and parameters_of(cls):
            before, heading, rest = (cls.__doc__ or "").partition("    Guarantees\n")
            lines = documentation(cls).replace("\n", "\n    ")
            cls.__doc__ = f"{before.rstrip()}\n\n    {lines}\n\n{heading}{rest}"

    def __init__(self, **parameters: Any) -> None:
        super().__init__(
            nInputPorts=len(self.inputs),
            inputType="vtkPolyData",
            nOutputPorts=len(self.outputs),
            outputType="vtkDataObject",
        )
        self.last_error: Exception | None = None
        self._will_raise = False
        self._told = 0.0
        self._share = (0.0, 1.0)
        for name, value in parameters.items():
            if name not in self.parameters():
                known = ", ".join(self.parameters()) or "none"
                raise ParameterError(f"{type(self).__name__} has no parameter {name!r}; it has: {known}.")
            setattr(self, name, value)

    @classmethod
    def parameters(cls) -> dict[str, Parameter]:
        """Return the declared parameters by name, in order."""
        return parameters_of(cls)

    @property
    def figures(self) -> dict[str, Any]:
        """What the last execution measured or did, as the command line's ``--json`` shows it."""
        summary: dict[str, Any] = getattr(self, "summary", {})
        return summary

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={getattr(self, name)!r}" for name in self.parameters())
        return f"{type(self).__name__}({values})"

    # -- what subclasses do ------------------------------------------------------------------------

    def execute(self, *inputs: Any) -> Any:
        """Return the output for vtkPolyData `inputs`, which must not be changed.

        A vtkPolyData; with several outputs a tuple of them.
        """
        raise NotImplementedError

    def progress(self, fraction: float, what: str = "") -> None:
        """Report progress (0 to 1) to VTK's observers.

        Raises
        ------
        Cancelled
            The filter has been asked to abort.
        """
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

        A filter with several outputs returns a tuple of them.

        Raises
        ------
        InvalidMeshError, ParameterError, Cancelled
            What ended the run.
        """
        if len(inputs) != len(self.inputs):
            raise TypeError(
                f"{type(self).__name__} takes {len(self.inputs)} inputs: {', '.join(self.inputs)}."
            )
        for port, data in enumerate(inputs):
            self.SetInputDataObject(port, data)
        try:
            self.Update()
            if self.last_error is not None:
                raise self.last_error
        finally:
            # VTK's abort flag sticks; the next call is another run.
            self.SetAbortExecute(0)
        if len(self.outputs) == 1:
            return self.GetOutputDataObject(0)
        return tuple(self.GetOutputDataObject(port) for port in range(len(self.outputs)))

    def Update(self, *arguments: Any) -> Any:
        """Bring the output up to date, as in VTK; raise what went wrong.

        An abort is no error here, as in VTK: the output is empty and `last_error` tells.
        """
        self._will_raise = True
        try:
            result = super().Update(*arguments)
        finally:
            self._will_raise = False
        if self.last_error is not None and not isinstance(self.last_error, Cancelled):
            raise self.last_error
        return result

    def SetInputData(self, *arguments: Any) -> None:
        """Set the data of input 0, or with two arguments of the input named first."""
        self.SetInputDataObject(*arguments)

    def GetOutput(self, port: int = 0) -> Any:
        """Return the output of the last execution."""
        return self.GetOutputDataObject(port)

    # -- VTK's side --------------------------------------------------------------------------------

    def FillInputPortInformation(self, port: int, info: Any) -> int:
        """Accept polydata and composite datasets of it."""
        info.Set(vtkAlgorithm.INPUT_REQUIRED_DATA_TYPE(), "vtkPolyData")
        info.Append(vtkAlgorithm.INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet")
        return 1

    def RequestDataObject(self, request: Any, inInfo: Any, outInfo: Any) -> int:
        """Make the outputs of the type of the first input."""
        source = vtkDataObject.GetData(inInfo[0], 0)
        for port in range(len(self.outputs)):
            output = vtkDataObject.GetData(outInfo, port)
            if source is not None and (output is None or not output.IsA(_plain_class(source))):
                outInfo.GetInformationObject(port).Set(vtkDataObject.DATA_OBJECT(), _new_like(source))
        return 1

    def RequestData(self, request: Any, inInfo: Any, outInfo: Any) -> int:
        """Run :meth:`execute` and turn exceptions into VTK errors."""
        outputs = [vtkDataObject.GetData(outInfo, port) for port in range(len(self.outputs))]
        self.last_error = None
        try:
            sources = [vtkDataObject.GetData(inInfo[port], 0) for port in range(len(self.inputs))]
            self._refuse_what_is_not_read()
            with compiling_ahead(type(self).__name__):
                self._execute_all(sources, outputs)
        except Cancelled as cancelled:
            self.last_error = cancelled
        except VtksmoothError as error:
            self.last_error = error
            self._say(f"{type(self).__name__}: {error}")
        except Exception as error:
            # A defect of ours must not look like success on VTK's side either.
            self.last_error = error
            self._say(f"{type(self).__name__} failed: {type(error).__name__}: {error}")
        if self.last_error is None:
            return 1
        for output in outputs:
            output.Initialize()
        self.SetAbortOutput(True)
        # "Failure" makes the executive print that a request failed. That is for those who pull on this
        # filter from downstream: an abort is none, and Update() is about to raise the exception itself.
        return int(self._will_raise or isinstance(self.last_error, Cancelled))

    def _refuse_what_is_not_read(self) -> None:
        for name, parameter in self.parameters().items():
            value = getattr(self, name)
            if value != parameter.default and not parameter.has_say(lambda other: getattr(self, other)):
                now = ", ".join(f"{other}={getattr(self, other)!r}" for other in parameter.only)
                raise ParameterError(
                    f"{name}={value!r} has no effect with {now}: leave it out; it has one where "
                    f"{parameter.where}."
                )

    def _execute_all(self, sources: list[Any], outputs: list[Any]) -> None:
        if not isinstance(sources[0], vtkCompositeDataSet):
            self._share = (0.0, 1.0)
            for number, source in enumerate(sources[1:], 2):
                if isinstance(source, vtkCompositeDataSet):
                    raise InvalidMeshError(
                        f"Input {number} is composite and input 1 is not; merge its blocks into one polydata."
                    )
            for output, result in zip(outputs, self._execute_tuple(sources), strict=True):
                output.ShallowCopy(result)
            return
        for output in outputs:
            output.CopyStructure(sources[0])
        leaves = sources[0].NewIterator()
        total = done = 0
        leaves.InitTraversal()
        while not leaves.IsDoneWithTraversal():
            total += 1
            leaves.GoToNextItem()
        leaves.InitTraversal()
        while not leaves.IsDoneWithTraversal():
            self._share = (done / total, (done + 1) / total)
            # A second input that is no composite belongs to every block.
            blocks = [
                source.GetDataSet(leaves) if isinstance(source, vtkCompositeDataSet) else source
                for source in sources
            ]
            results = self._execute_block(leaves.GetCurrentFlatIndex(), blocks)
            for output, result in zip(outputs, results, strict=True):
                output.SetDataSet(leaves, result)
            done += 1
            leaves.GoToNextItem()

    def _execute_tuple(self, sources: list[Any]) -> tuple[Any, ...]:
        result = self.execute(*sources)
        return result if isinstance(result, tuple) else (result,)

    def _execute_block(self, index: int, blocks: list[Any]) -> tuple[Any, ...]:
        if not all(isinstance(block, vtkPolyData) for block in blocks):
            names = ", ".join("nothing" if block is None else _plain_class(block) for block in blocks)
            raise InvalidMeshError(f"Block {index} must be polydata, not {names}; extract its surface first.")
        if blocks[0].GetNumberOfPolys() + blocks[0].GetNumberOfStrips() == 0:
            # Pieces without faces are usual in composite data.
            return (blocks[0], *(vtkPolyData() for _ in self.outputs[1:]))
        try:
            return self._execute_tuple(blocks)
        except VtksmoothError as error:
            if isinstance(error, Cancelled):
                raise
            raise type(error)(f"Block {index}: {error}") from error

    def _say(self, message: str) -> None:
        if self.HasObserver("ErrorEvent"):
            self.InvokeEvent("ErrorEvent", message)
        elif not self._will_raise:
            vtkOutputWindow.GetInstance().DisplayErrorText(message + "\n")


def _plain_class(data: Any) -> str:
    # Objects may be of a Python subclass (pyvista.PolyData) whose name VTK does not know.
    return next(base.__name__ for base in type(data).__mro__ if base.__module__.startswith("vtkmodules."))


def _new_like(data: Any) -> Any:
    return next(base for base in type(data).__mro__ if base.__module__.startswith("vtkmodules."))()


def output_like(source: Any) -> vtkPolyData:
    """Return a new polydata that shares everything with `source`; its field data may be added to."""
    output = vtkPolyData()
    output.ShallowCopy(source)
    # VTK shares the *container* of field data between shallow copies.
    fields = vtkFieldData()
    fields.ShallowCopy(source.GetFieldData())
    output.SetFieldData(fields)
    return output


def add_field(output: vtkPolyData, name: str, value: npt.ArrayLike | str) -> None:
    """Add numbers or a text to the field data of `output`."""
    if isinstance(value, str):
        text = vtkStringArray()
        text.SetName(name)
        text.InsertNextValue(value)
        output.GetFieldData().AddArray(text)
    else:
        output.GetFieldData().AddArray(vtk_array(np.atleast_1d(np.asarray(value)), name))
