"""Which wrenches the cables can exert within their limits, and with which tensions: six cables in one way, more in many."""

from itertools import combinations

import numpy as np

from rig import apply, swapped


def extremes(rig, q, wrench):
    """Smallest and greatest tension over rows of poses and wrenches; of more than six cables as even as they can be: the greatest smallest one, the smallest greatest one."""
    matrix = rig.matrix(q)
    if rig.cables == 6:
        found = apply(np.linalg.inv(matrix), wrench)
        return found.min(), found.max()
    return _evenest(matrix, wrench).min(), -_evenest(matrix, -wrench).min()


def keeps(rig, q, wrench, slip):
    """Whether tensions within the limits, but for a `slip` (N), exert the wrenches of all rows."""
    if rig.cables == 6:
        smallest, greatest = extremes(rig, q, wrench)
        return bool(smallest > rig.least - slip and greatest < rig.greatest + slip)
    planes, bounds = halfspaces(rig, q)
    return bool((apply(planes, wrench) <= bounds + slip).all())


def _evenest(matrix, wrench):
    """max t with u >= t and W u = w, a row each: u = W+ w + N z, by all corners of the dual linear programme."""
    n = matrix.shape[-1]
    particular = apply(np.linalg.pinv(matrix), wrench)
    null = swapped(np.linalg.svd(matrix)[2][..., 6:, :])
    rows = np.concatenate([null, np.ones((*null.shape[:-1], 1))], axis=-1)
    corners = np.array(list(combinations(range(n), n - 5)))
    # Weights of the corner's cables, 0 or more, that sum up to 1 and are across N.
    systems = swapped(rows[..., corners, :])
    regular = np.abs(np.linalg.det(systems)) > 1e-12
    inverses = np.linalg.inv(np.where(regular[..., None, None], systems, np.eye(n - 5)))
    weights = inverses[..., -1]
    values = (weights * particular[..., corners]).sum(-1)
    return np.where(regular & (weights > -1e-9).all(-1), values, np.inf).min(-1)


def halfspaces(rig, q):
    """F and g of the wrenches F w <= g that tensions within the limits can exert, (..., m, 6) and (..., m): two planes for each five cables, (M3) of docs/minimum-time.md.
    Rows are scaled to N of the cable that counts most."""
    matrix = rig.matrix(q)
    fives = np.array(list(combinations(range(rig.cables), 5)))
    spanned = np.moveaxis(matrix[..., fives], -2, -3)
    across = np.linalg.svd(swapped(spanned))[2][..., -1, :]
    others = np.ones((len(fives), rig.cables))
    np.put_along_axis(others, fives, 0, axis=1)
    pulls = (across @ matrix) * others
    size = np.abs(pulls).max(axis=-1, keepdims=True)
    across, pulls = across / size, pulls / size
    ends = pulls * rig.least, pulls * rig.greatest
    most, least = np.maximum(*ends).sum(-1), np.minimum(*ends).sum(-1)
    return np.concatenate([across, -across], axis=-2), np.concatenate([most, -least], axis=-1)
