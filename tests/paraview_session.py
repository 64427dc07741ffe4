"""What the tests do inside ParaView: run by pvpython with a JSON file of what to do; answers in another."""

import json
import sys
import time
from pathlib import Path

from paraview import servermanager, simple
from vtkmodules import vtkIOXML

folder = Path(sys.argv[1])
asked = json.loads((folder / "asked.json").read_text())
answers = {"taken": sorted(set(asked["names"]) & set(dir(simple)))}


def said(text):
    """Divide what ParaView prints: the tests look for the lines between two of these."""
    sys.stderr.flush()
    print(f"<{text}>", file=sys.stderr, flush=True)


def save(proxy, name):
    """Save every output of a proxy; return the files, None for what is empty."""
    files = []
    for port in range(proxy.SMProxy.GetNumberOfOutputPorts()):
        data = servermanager.Fetch(simple.OutputPort(proxy, port), idx=port)
        if data.GetNumberOfPoints() == 0:
            files.append(None)
            continue
        blocks = data.IsA("vtkMultiBlockDataSet")
        writer = vtkIOXML.vtkXMLMultiBlockDataWriter() if blocks else vtkIOXML.vtkXMLPolyDataWriter()
        files.append(str(folder / f"{name}-{port}.{writer.GetDefaultFileExtension()}"))
        writer.SetFileName(files[-1])
        writer.SetInputData(data)
        writer.Write()
    return files


def readers_of(files):
    """Return a reader for each file, up to date."""
    readers = [simple.OpenDataFile(file) for file in files]
    for reader in readers:
        reader.UpdatePipeline()
    return readers


def run():
    """Run filters: name, inputs by name, properties."""
    for job in asked["jobs"]:
        said(job["id"])
        inputs = dict(zip(job["inputs"], readers_of(job["inputs"].values()), strict=True))
        proxy = filters[job["filter"]](**inputs)
        for name, value in job["properties"].items():
            setattr(proxy, name, value)
        proxy.UpdatePipeline()
        answers[job["id"]] = save(proxy, job["id"])


def watch():
    """Record progress, as the filter sends it and as ParaView's bar gets it; abort; run again."""
    said("watch")
    proxy = filters["TrapeziumDrawing"](Input=readers_of([asked["mesh"]])[0])
    filter = proxy.GetClientSideObject()
    sent, shown = [], []

    def hear(*_):
        sent.append(filter.GetProgress())
        time.sleep(0.02)  # ParaView passes over what follows too soon

    number = filter.AddObserver("ProgressEvent", hear)
    handler = servermanager.ActiveConnection.Session.GetProgressHandler()
    handler.SetProgressInterval(handler.GetProgressIntervalMinValue())
    handler.AddObserver(
        "ProgressEvent", lambda *_: shown.append([handler.GetLastProgressText(), handler.GetLastProgress()])
    )
    proxy.UpdatePipeline()
    answers["progress"] = {"sent": sent, "shown": shown}
    filter.RemoveObserver(number)
    number = filter.AddObserver("ProgressEvent", lambda *_: filter.SetAbortExecute(1))
    proxy.Iterations = 7
    proxy.UpdatePipeline()
    answers["aborted"] = proxy.GetDataInformation().GetNumberOfPoints()
    filter.RemoveObserver(number)
    proxy.Iterations = 8
    proxy.UpdatePipeline()
    answers["after"] = proxy.GetDataInformation().GetNumberOfPoints()


def state():
    """Save a state with every kind of property changed; where there is a screen, a picture."""
    said("state")
    for source in list(simple.GetSources().values()):
        simple.Delete(source)
    reader = readers_of([asked["mesh"]])[0]
    proxy = filters["LaplacianSmoothing"](
        Input=reader, Iterations=4, Scheme="taubin", TangentPlane=1, Fixed="Pins",
        UseStopNormalDeviation=1, StopNormalDeviation=170.0, PassBand=0.25,
    )  # fmt: skip
    if asked["screen"]:
        view = simple.CreateView("RenderView")
        simple.Show(proxy, view)
        view.ResetCamera()
        simple.SaveScreenshot(str(folder / "picture.png"), view, ImageResolution=[400, 300])
    proxy.UpdatePipeline()
    simple.SaveState(str(folder / "state.pvsm"))
    answers["saved"] = save(proxy, "saved")


def reload():
    """Load the state again and run it."""
    said("reload")
    simple.LoadState(str(folder / "state.pvsm"))
    (proxy,) = [
        source for source in simple.GetSources().values() if source.GetXMLName() == "LaplacianSmoothing"
    ]
    proxy.UpdatePipeline()
    answers["reloaded"] = save(proxy, "reloaded")
    answers["properties"] = {
        name: proxy.GetProperty(name).GetData()
        for name in ("Iterations", "Scheme", "TangentPlane", "Fixed", "PassBand")
    }


filters = dict(vars(simple))
if asked["plugin"]:
    simple.LoadPlugin(asked["plugin"], remote=False, ns=filters)
for step in asked["steps"]:
    globals()[step]()
(folder / "answers.json").write_text(json.dumps(answers))
