"""Every name of the package is documented, and the examples in the documentation are so."""

from __future__ import annotations

import doctest
import inspect
import unittest

import longstep

# Data of callers, which has no code.
WITHOUT_EXAMPLES = {"Environment", "Message", "Observation", "Request", "RunQuestion", "RunView", "SessionView"}


class Docstrings(unittest.TestCase):
    def test_examples_in_docstrings_are_so(self) -> None:
        parser, runner = doctest.DocTestParser(), doctest.DocTestRunner()
        attempted = 0
        for name in ("longstep", *longstep.__all__):
            text = inspect.getdoc(longstep if name == "longstep" else getattr(longstep, name)) or ""
            test = parser.get_doctest(text, {"longstep": longstep}, name, None, None)
            attempted += len(test.examples)
            runner.run(test)
        self.assertEqual(runner.summarize(verbose=False).failed, 0)
        self.assertGreater(attempted, 20)

    def test_every_name_is_documented(self) -> None:
        for name in longstep.__all__:
            own = getattr(longstep, name)
            if name == "__version__":
                continue
            self.assertTrue(own.__doc__, name)
            for member, value in vars(own).items() if inspect.isclass(own) else ():
                if not member.startswith("_") and name not in WITHOUT_EXAMPLES and (callable(value) or inspect.isdatadescriptor(value)):
                    self.assertTrue(value.__doc__, f"{name}.{member}")


if __name__ == "__main__":
    unittest.main()
