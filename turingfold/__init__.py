"""Cortical folding in two dimensions; each public name is imported when it is first used."""

__version__ = "0.1.0"


def __getattr__(name: str) -> object:
    """Return a public name; the list of them is read, and replaces this function, when the first is used."""
    import lazy_loader

    attached = lazy_loader.attach_stub(__name__, __file__)
    globals().update(zip(("__getattr__", "__dir__", "__all__"), attached, strict=True))
    return attached[2] if name == "__all__" else attached[0](name)


def __dir__() -> list[str]:
    return list(__getattr__("__all__"))  # type: ignore[call-overload]
