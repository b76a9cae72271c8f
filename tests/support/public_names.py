"""Public names of the package, each of which has a page of the site and an example."""

import aomc_sky


def public_names():
    """What `import aomc_sky` offers, modules by what they say is theirs."""
    names = [name for name in aomc_sky.__all__ if name != "__version__"]
    names += [f"{module}.{name}" for name, module in aomc_sky._OLD.items()]
    for module in aomc_sky._PUBLIC_MODULES:
        ours = getattr(aomc_sky, module)
        names += [f"{module}.{name}" for name in getattr(ours, "__all__", []) if callable(getattr(ours, name))]
    return list(dict.fromkeys(names))
