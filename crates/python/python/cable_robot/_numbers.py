"""What users give, as the library takes it."""


def numbers(name, values, counts=(6,)):
    """Values as a tuple of floats; their number is one of `counts`."""
    try:
        found = tuple(float(value) for value in values)
    except TypeError:
        raise ValueError(f"{name} = {values!r}: {' or '.join(map(str, counts))} numbers are wanted") from None
    if len(found) not in counts:
        raise ValueError(f"{name} = {found}: {' or '.join(map(str, counts))} numbers are wanted, not {len(found)}")
    return found


def pose(name, values):
    """x, y, z, roll, pitch, yaw; angles that are left out are 0."""
    return (numbers(name, values, (3, 6)) + (0.0, 0.0, 0.0))[:6]


def six(name, values):
    """Rates or accelerations of the six coordinates; `None` is zero."""
    return (0.0,) * 6 if values is None else numbers(name, values)


def options(planner=None, lambda_=None, eta=None, lift=0.0, max_tension_rate=0.0):
    """What goes to the controller."""
    return {"planner": planner, "lambda": lambda_, "eta": eta, "lift": lift, "max_tension_rate": max_tension_rate}


def axes(given):
    """The axes given, or new ones; matplotlib is an extra: pip install cable-robot[plot]."""
    if given is not None:
        return given
    import matplotlib.pyplot as plt

    return plt.subplots(layout="constrained")[1]
