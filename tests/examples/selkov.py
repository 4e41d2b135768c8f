"""Sel'kov's glycolysis: ∂u/∂t = d_u ∇²u - u + a v + u² v,  ∂v/∂t = d_v ∇²v + b - a v - u² v (1968)."""
from dataclasses import dataclass

from turingfold.extend import Kinetics


@dataclass(frozen=True)
class Selkov(Kinetics):
    """Autocatalysis of u, fed by v at the rate b; a: conversion of v without u."""

    a: float = 0.1
    b: float = 1.0
    published_ratio = 20.0  # of d_v to d_u where none is given: a pattern forms from 9.1 on

    def rates(self, u, v):
        gain = self.a * v + u**2 * v
        return gain - u, self.b - gain

    def derivatives(self, u, v):
        by_u, by_v = 2 * u * v, self.a + u**2
        return by_u - 1, by_v, -by_u, -by_v

    def steady_states(self):
        return ((self.b, self.b / (self.a + self.b**2)),)
