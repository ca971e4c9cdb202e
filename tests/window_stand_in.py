# SPDX-License-Identifier: GPL-2.0-or-later
"""A matplotlib backend that stands in for windows on a screen: nothing is shown, what is drawn is counted.

`mood` says what the window does when it handles its events: nothing, be closed by the user, or fail.
"""

from matplotlib._pylab_helpers import Gcf
from matplotlib.backend_bases import FigureManagerBase
from matplotlib.backends.backend_agg import FigureCanvasAgg

mood = "open"
shown = []


class FigureManager(FigureManagerBase):
    pass


class FigureCanvas(FigureCanvasAgg):
    manager_class = FigureManager

    def flush_events(self):
        if mood == "broken":
            raise RuntimeError("application has been destroyed")
        shown.append(self.figure.axes[0].images[0].get_array().copy())
        if mood == "closed":
            Gcf.destroy(self.manager)
