"""Installs the cases, a folder beside the package, as turingfold.cases; the rest is in pyproject.toml."""

from setuptools import find_packages, setup

setup(
    packages=[*find_packages(include=["turingfold*"]), "turingfold.cases"],
    package_dir={"turingfold.cases": "cases"},
)
