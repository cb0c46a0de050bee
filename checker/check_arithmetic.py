"""Checks the arithmetic of the certificates against Arb's balls: lines of `cargo run --example arithmetic` on standard input.

A value of exp, expm1, sin, cos, sinh, cosh must be within 4 units of 2^-52 of the true one (sin and cos: of 1). The result of an operation
on Taylor models must enclose what the operation makes of any functions in its operands: tried at 9 times with the operands' errors at
their ends. Prints how many lines of each kind were checked and the largest error, as a share of what is allowed; exit code 1 if any is beyond it.
"""

import struct
import sys
from collections import defaultdict

from flint import arb, ctx

ctx.prec = 160
ALLOWED = 4 * arb(2) ** -52
ORDER = 6
TIMES = [arb(k) / 4 for k in range(-4, 5)]


def double(text):
    return struct.unpack(">d", bytes.fromhex(text))[0]


FUNCTIONS = {
    "exp": arb.exp,
    "expm1": arb.expm1,
    "sin": arb.sin,
    "cos": arb.cos,
    "sinh": arb.sinh,
    "cosh": arb.cosh,
}


def function_error(name, argument, value):
    """Error of a function's value as a share of what is allowed."""
    true = FUNCTIONS[name](arb(argument))
    off = abs(arb(value) - true)
    if name in ("sin", "cos"):
        return off / ALLOWED
    if abs(value) < 2.3e-308:  # gradual underflow: what is left out is less than any error that is kept
        return off / arb(2.3e-308)
    return off / (ALLOWED * abs(true))


def models(numbers):
    """Taylor models: coefficients and error, 7 numbers each."""
    return [([arb(x) for x in numbers[k : k + ORDER]], arb(numbers[k + ORDER])) for k in range(0, len(numbers), ORDER + 1)]


def at(model, tau, side=0):
    """A function of a model at a time: its polynomial and `side` (-1, 0, 1) times its error."""
    coefficients, error = model
    value = arb(0)
    for coefficient in reversed(coefficients):
        value = value * tau + coefficient
    return value + side * error


def exactly(name, parameters, operands, tau, sides):
    """What the operation makes of functions in its operands at a time."""
    values = [at(model, tau, side) for model, side in zip(operands, sides)]
    if name == "decay":
        rate, middle, half = parameters
        return (-rate * (middle + half * tau)).exp()
    if name == "integrated":
        rate, middle, half = parameters
        time = middle + half * tau
        return time if rate == 0 else -(-rate * time).expm1() / rate
    a = values[0]
    b = values[1] if len(values) > 1 else None
    return {
        "add": lambda: a + b,
        "sub": lambda: a - b,
        "mul": lambda: a * b,
        "scale": lambda: parameters[0] * a,
        "combination": lambda: parameters[0] * a + parameters[1] * b,
        "inverse": lambda: 1 / a,
        "sqrt": lambda: a.sqrt(),
        "sin": lambda: a.sin(),
        "cos": lambda: a.cos(),
    }[name]()


PARAMETERS = {"scale": 1, "combination": 2, "decay": 3, "integrated": 3}


def model_error(name, numbers):
    """Largest error of a result as a share of what it claims."""
    count = PARAMETERS.get(name, 0)
    parameters = [arb(x) for x in numbers[:count]]
    *operands, result = models(numbers[count:])
    if not result[1].is_finite():
        return arb(0)  # it claims nothing
    worst = arb(0)
    for tau in TIMES:
        for sides in [(-1, -1), (-1, 1), (0, 0), (1, -1), (1, 1)] if operands else [()]:
            if name == "sqrt" and at(operands[0], tau, sides[0]) < 0:
                continue  # asked of functions that are 0 or more only
            off = abs(exactly(name, parameters, operands, tau, sides) - at(result, tau))
            share = off / result[1] if result[1] > 0 else (arb(0) if off == 0 else arb("inf"))
            worst = worst.max(share)
    return worst


def main():
    counts, worst = defaultdict(int), defaultdict(lambda: arb(0))
    bad = 0
    for number, line in enumerate(sys.stdin, 1):
        name, *words = line.split()
        numbers = [double(word) for word in words]
        if name in FUNCTIONS and len(numbers) == 2:
            error = function_error(name, *numbers)
        else:
            name, error = name + " of models", model_error(name, numbers)
        counts[name] += 1
        worst[name] = worst[name].max(error)
        if not error <= 1:
            bad += 1
            if bad <= 10:
                print(f"line {number}: {line.strip()}: {error.str(5, radius=False)} of what is allowed", file=sys.stderr)
        if number % 1_000_000 == 0:
            print(f"{number} lines", file=sys.stderr)
    for name in sorted(counts):
        print(f"{name:24} {counts[name]:>10}  at most {float(worst[name]):.3f} of what is allowed")
    if not counts:
        print("nothing on standard input", file=sys.stderr)
    return 1 if bad or not counts else 0


if __name__ == "__main__":
    sys.exit(main())
