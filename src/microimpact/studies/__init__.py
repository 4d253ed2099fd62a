"""Studies: one module per analysis, each from a branch of the configuration to tables.

A study module bears the name of its branch in ``config/config.yaml`` and defines a frozen
dataclass ``Params`` and a pure function ``run(params, inputs)`` that returns its tables by
name. Modules are found by name; nothing is registered here.
"""
