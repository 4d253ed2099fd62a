from .run.study import run_study as run_study

__all__ = ["run_study"]
