"""Every command of the application, declared once: menus, tool bar, keys and cheat sheet come from here."""

from __future__ import annotations

from dataclasses import dataclass

from .model.overlays import OVERLAYS
from .model.units import UNITS

#: Colours for the overlays: perceptually uniform, and readable with any colour vision.
COLOURS = ("viridis", "cividis", "plasma", "inferno")


@dataclass(frozen=True)
class Command:
    """Something that a user can ask for.

    Attributes
    ----------
    id : str
        A controller has a method of this name.
    title : str
    menu : str
        Menu that it is in; "Filters > More" would be a submenu.
    key : str
        Its shortcut, as Qt writes it.
    tip : str
        What it does, if the title does not say it all.
    checked : bool or None
        None: no switch; otherwise its first position.
    group : str
        Of the switches of one group exactly one is on.
    tool : bool
        Whether it is in the tool bar.
    """

    id: str
    title: str
    menu: str
    key: str = ""
    tip: str = ""
    checked: bool | None = None
    group: str = ""
    tool: bool = False


def overlay_id(overlay: str) -> str:
    """Return the id of the command that shows an overlay."""
    return f"overlay_{overlay.replace('-', '_')}"


COMMANDS: tuple[Command, ...] = (
    Command("open", "Open…", "File", "Ctrl+O", "Open meshes, each as a layer", tool=True),
    Command("save", "Save", "File", "Ctrl+S", "Write the active layer; asks for a name at first", tool=True),
    Command("save_as", "Save As…", "File", "Ctrl+Shift+S", "Write the active layer to another file"),
    Command("open_session", "Open Session…", "File", tip="Everything as it was saved"),
    Command("save_session", "Save Session", "File", "Ctrl+E", "Layers, history and views in one file"),
    Command("save_session_as", "Save Session As…", "File"),
    Command("close_layer", "Close Layer", "File", "Ctrl+W", "Close the active layer; undo brings it back"),
    Command("screenshot", "Screenshot…", "File", "F12", "Picture of the view, of any size"),
    Command("quit", "Quit", "File", "Ctrl+Q"),
    Command("undo", "Undo", "Edit", "Ctrl+Z", tool=True),
    Command("redo", "Redo", "Edit", "Ctrl+Shift+Z", tool=True),
    Command("copy_numbers", "Copy Numbers as Markdown", "Edit", "Ctrl+Shift+C"),
    Command("memory_limit", "Memory of the History…", "Edit"),
    Command("toggle_before", "Before", "View", "Space", "Show the mesh as it was before", False, tool=True),
    Command("split", "Split View", "View", "S", "Before and after side by side", False, tool=True),
    Command("swipe", "Swipe", "View", "X", "Before and after, left and right of a line", False, tool=True),
    Command("frame", "Frame", "View", "F", "Bring the whole mesh into view", tool=True),
    Command("edges", "Edges", "View", "E", "Show the edges of the faces", True, tool=True),
    Command("bad_faces", "Outline Bad Faces", "View", "B", "Outline faces worse than bad", False, tool=True),
    Command("bands", "Colour Bands", "View", "G", "Four colours, cut at the thresholds", False),
    Command("parallel", "Parallel Projection", "View", "P", checked=False),
    Command("dark", "Dark", "View", "Ctrl+D", "Light or dark", False),
    *(
        Command(f"view_{name}", f"From {title}", "View > Camera", f"Alt+{number}")
        for number, (name, title) in enumerate(
            (("px", "+X"), ("nx", "-X"), ("py", "+Y"), ("ny", "-Y"), ("pz", "+Z"), ("nz", "-Z")), 1
        )
    ),
    Command(overlay_id("none"), "Plain", "Overlay", "0", "No overlay", False, "overlay"),
    *(
        Command(
            overlay_id(one.id), one.title, "Overlay", "123456789M"[number - 1 : number], one.help,
            one is OVERLAYS[0], "overlay",
        )
        for number, one in enumerate(OVERLAYS, 1)
    ),
    *(
        Command(f"colours_{name}", name.capitalize(), "Overlay > Colours", "", "", not number, "colours")
        for number, name in enumerate(COLOURS)
    ),
    Command("reset_thresholds", "Reset Thresholds", "Overlay", "Ctrl+T", "Good, warning, bad as they were"),
    Command("papers_bins", "Bins of the Papers", "Overlay", "Ctrl+B", "Histogram of k in six bins", False),
    Command("lock_brush", "Lock Brush", "Overlay", "L", "Keep the faces that the brush selects", False),
    Command("next_worst", "Next Worst Face", "Overlay", "W", "Go to the next worst face"),
    Command("previous_worst", "Previous Worst Face", "Overlay", "Shift+W"),
    *(
        Command(f"region_{name}", tool, "Regions", key, tip, name == "camera", "region")
        for name, tool, key, tip in (
            ("camera", "Turn the View", "", "Leave the tools (Esc)"),
            ("brush", "Paint", "Shift+B", "Paint over points to fix them"),
            ("lasso", "Lasso", "Shift+R", "Draw round points to fix them"),
            ("line", "Pick Line", "Shift+L", "Click on a feature line to fix it"),
            ("patch", "Pick Patch", "Shift+P", "Click on what lies between feature lines to fix it"),
            ("component", "Pick Component", "Shift+C", "Click on what is connected to fix it"),
            ("edges", "Draw Lines", "Shift+D", "Add and remove feature lines"),
        )
    ),
    Command("region_free", "Free Instead of Fix", "Regions", "Shift+F", "With Ctrl the opposite", False),
    Command("region_through", "Through the Mesh", "Regions", "Shift+T", "Reach hidden points as well", False),
    Command("region_smaller", "Smaller Brush", "Regions", "["),
    Command("region_larger", "Larger Brush", "Regions", "]"),
    Command("region_threshold", "Mark by Threshold", "Regions", "Ctrl+M", "Points by the overlay's values"),
    Command("region_grow", "Grow", "Regions", "+", "Fix one more ring of points"),
    Command("region_shrink", "Shrink", "Regions", "-", "Free the outermost ring of points"),
    Command("region_invert", "Invert", "Regions", "I", "Free what is fixed, and fix what is free"),
    Command("region_soften", "Soften the Edge", "Regions", "Shift+S", "Weights that rise from 0 to 1"),
    Command("region_clear", "Clear", "Regions", tip="Free all points"),
    Command("region_clear_lines", "Clear Lines", "Regions", tip="Forget lines added and removed"),
    Command("apply", "Apply Filter", "Filters", "Ctrl+Return", "Run the filter on the active layer"),
    Command("cancel", "Cancel", "Filters", "Esc", "Stop what runs; the mesh stays as it was"),
    Command("preview", "Live Preview", "Filters", "Ctrl+P", "Show what the filter would do", False),
    Command("open_recipe", "Open Recipe…", "Recipe", "Ctrl+Shift+O", "A recipe for the active layer"),
    Command("save_recipe", "Save Recipe…", "Recipe", "Ctrl+Alt+S", "As JSON, or as a script"),
    Command("run_recipe", "Run Recipe", "Recipe", "Ctrl+R", "Run what was edited, from there on"),
    Command("revert_recipe", "Revert", "Recipe", tip="Forget the edits that have not been run"),
    Command("copy_script", "Copy as VTK Script", "Recipe", "Ctrl+Shift+L"),
    Command("copy_pyvista", "Copy as PyVista Script", "Recipe"),
    Command("copy_command", "Copy as Command Line", "Recipe"),
    Command("batch", "Batch…", "Recipe", "Ctrl+Shift+B", "A recipe on many files"),
    Command("report", "Report…", "Recipe", "Ctrl+Shift+R", "A page with pictures, measures and the recipe"),
    Command("measure_distance", "Distance", "Measure", "D", "Pick two points", False),
    Command("measure_angle", "Angle", "Measure", "A", "Pick three points, the apex second", False),
    Command(
        "measure_radius", "Radius", "Measure", "R",
        "Pick a face: sphere and cylinder that fit its surroundings best", False,
    ),
    Command("fixed_radius", "Radius of Fixed Points", "Measure", "", "Of a region painted or picked by hand"),
    Command("remove_measurements", "Remove", "Measure", "", "Remove the measurements selected, or all"),
    Command("section", "Cross-Section", "Measure", "C", "Cut with a plane that can be dragged", False),
    *(
        Command(f"section_{axis}", f"Across {axis.upper()}", "Measure > Plane", "", f"Cut across {axis}")
        for axis in "xyz"
    ),
    Command("section_view", "Across the View", "Measure > Plane", "", "Cut along the line of sight, upright"),
    Command("compare_layers", "Compare Layers…", "Measure", "K", "How far one layer is from another"),
    *(
        Command(f"unit_{unit or 'none'}", title, "Measure > Unit", "", "Unit of lengths", not unit, "unit")
        for unit, title in UNITS.items()
    ),
    Command("cheat_sheet", "Keyboard Shortcuts", "Help", "H"),
    Command("about", "About", "Help", tip="Versions, for a report of a defect"),
)  # fmt: skip

#: The menus in their order.
MENUS = ("File", "Edit", "View", "Overlay", "Regions", "Filters", "Recipe", "Measure", "Help")
