"""Build the network of halo in TouchDesigner: README.md has the line for the Textport.

It needs the path `folder`, and `op` of TouchDesigner. A second run replaces `/project1/halo`.
Operators and parameters are those of Derivative's documentation; it was not run in TouchDesigner.
"""

# ruff: noqa: ANN001, ANN003, ANN201, T201

FLAT_PORT, FRAMES_PORT, TUIO_PORT = 7000, 4256, 3333
FINGERS = 10
WIDTH_PX, HEIGHT_PX = 1920, 1080
POINTER_COLUMNS = "slot id touch u v x_mm y_mm hover_mm pressure force_g".split()  # noqa: SIM905
HIT_COLUMNS = "kind id slot u v strike_mm_s contacts".split()  # noqa: SIM905
ON_TOUCH = """# Your own code. A touch has: kind id slot u v strike_mm_s contacts
# u is 0 left and 1 right, v is 0 at the far edge and 1 at the near edge.

def onDown(touch):
    print('down', touch.slot, touch.u, touch.v, touch.strike_mm_s)

def onUp(touch):
    print('up', touch.slot)
"""
TICK = """def onFrameStart(frame):
    me.parent().op('callbacks').module.tick(me.parent())
"""


def build(parent, folder):
    """Build all operators inside the COMP `parent`; return the new COMP."""
    old = parent.op("halo")
    if old:
        old.destroy()
    comp = parent.create("baseCOMP", "halo")
    build_inputs(comp, folder)
    build_picture(comp)
    return comp


def build_inputs(comp, folder):
    source = (folder / "halo_callbacks.py").read_text(encoding="utf-8")
    make(comp, "textDAT", "callbacks", (150, 0)).text = source
    make(comp, "textDAT", "on_touch", (300, 0)).text = ON_TOUCH
    table(comp, "pointers", (150, -150), POINTER_COLUMNS, rows=FINGERS)
    table(comp, "hits", (300, -150), HIT_COLUMNS)
    frames = {"port": FRAMES_PORT, "splitbundle": True, "callbacks": "callbacks"}
    make(comp, "oscinDAT", "frames_in", (0, 0), **frames, active=True)
    make(comp, "executeDAT", "tick", (0, -150), framestart=True, active=True).text = TICK
    make(comp, "oscinCHOP", "flat_in", (0, 150), port=FLAT_PORT, stripsegments=3, active=True)
    slot = make(comp, "selectCHOP", "slot0", (150, 150), channames="*slot?0?*")
    slot.inputConnectors[0].connect(comp.op("flat_in"))
    make(comp, "tuioinDAT", "tuio_in", (300, 150), port=TUIO_PORT, active=False)


def build_picture(comp):
    """A circle for each slot, and the projector's picture."""
    size = {"outputresolution": "custom", "resolutionw": WIDTH_PX, "resolutionh": HEIGHT_PX}
    all_circles = make(comp, "compositeTOP", "surface", (750, -375), operand="maximum")
    for slot in range(FINGERS):
        place = (150 * (slot % 5), -300 - 150 * (slot // 5))
        circle = make(comp, "circleTOP", f"finger{slot}", place, bgalpha=1, **size)
        circle.par.radiusunit = circle.par.centerunit = "fraction"
        for name, expression in circle_expressions(slot).items():
            getattr(circle.par, name).expr = expression
        all_circles.inputConnectors[slot].connect(circle)
    projector = make(comp, "cornerpinTOP", "projector", (900, -375), extractmapping="perspective")
    projector.inputConnectors[0].connect(all_circles)


def circle_expressions(slot):
    """A circle at the finger: larger when it presses, blue in the air, orange in touch."""
    cell = f"float(op('pointers')[{slot + 1}, '%s'])"
    radius = f"(0.01 + 0.02 * {cell % 'pressure'}) * ({cell % 'hover_mm'} >= 0)"
    return {
        "centerx": f"{cell % 'u'} - 0.5",
        "centery": f"0.5 - {cell % 'v'}",
        "radiusx": radius,
        "radiusy": f"{radius} * me.width / me.height",
        "fillcolorr": cell % "touch",
        "fillcolorg": "0.7",
        "fillcolorb": f"1 - {cell % 'touch'}",
    }


def table(comp, name, place, columns, rows=0):
    operator = make(comp, "tableDAT", name, place)
    operator.clear()
    operator.appendRow(columns)
    for slot in range(rows):
        values = {"slot": slot, "id": -1, "hover_mm": -1, "force_g": -1}
        operator.appendRow([values.get(column, 0) for column in columns])


def make(comp, kind, name, place, **parameters):
    operator = comp.create(kind, name)
    operator.nodeX, operator.nodeY = place
    for parameter, value in parameters.items():
        try:
            setattr(operator.par, parameter, value)
        except Exception:  # TouchDesigner's own error type; versions differ in a few names.
            print(f"halo: {name} has no parameter {parameter} here: set it to {value} by hand")
    return operator


build(op("/project1"), folder)  # noqa: F821 - both are given where this text is executed
print("halo: built /project1/halo")
