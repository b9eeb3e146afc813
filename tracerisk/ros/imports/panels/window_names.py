"""Names in libraries for windows, by which a run without a screen knows what they do."""

from __future__ import annotations

import re
import runpy
import sysconfig
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path

_STARRED: Mapping[str, str] = {
    "tkinter": (
        "BooleanVar Button Canvas Checkbutton DoubleVar Entry Frame IntVar Label LabelFrame "
        "Listbox Menu Menubutton Message OptionMenu PanedWindow PhotoImage Radiobutton Scale "
        "Scrollbar Spinbox StringVar TclError Text Tk Toplevel Variable Widget mainloop"
    ),
    "tkinter.ttk": (
        "Button Checkbutton Combobox Entry Frame Label LabelFrame Labelframe Menubutton Notebook "
        "PanedWindow Progressbar Radiobutton Scale Scrollbar Separator Sizegrip Spinbox Style "
        "Treeview Widget"
    ),
    "QtWidgets": (
        "QAction QApplication QButtonGroup QCheckBox QComboBox QDesktopWidget QDial QDialog "
        "QDoubleSpinBox QFileDialog QFormLayout QFrame QGridLayout QGroupBox QHBoxLayout "
        "QInputDialog QLCDNumber QLabel QLineEdit QListWidget QListWidgetItem QMainWindow QMenu "
        "QMenuBar QMessageBox QPlainTextEdit QProgressBar QPushButton QRadioButton QScrollArea "
        "QSizePolicy QSlider QSpacerItem QSpinBox QSplitter QStackedWidget QStatusBar QTabWidget "
        "QTableWidget QTableWidgetItem QTextBrowser QTextEdit QToolBar QToolButton QVBoxLayout "
        "QWidget"
    ),
    "QtCore": (
        "QCoreApplication QDateTime QEvent QMutex QObject QPoint QPointF QProcess QRect QRectF "
        "QRunnable QSettings QSize QThread QThreadPool QTime QTimer QUrl Qt Signal Slot pyqtSignal "
        "pyqtSlot"
    ),
    "QtGui": (
        "QBrush QCloseEvent QColor QCursor QFont QIcon QImage QKeyEvent QKeySequence QMovie "
        "QPainter QPalette QPen QPixmap QStandardItem QStandardItemModel QTextCursor"
    ),
}
"""What `import *` takes of a module, by the end of its name; of Qt what is most used."""
ENDS = re.compile(r"(^|_|\b)(quit|exit|destroy|closing|shutdown|emergency)(_|\b|$)", re.IGNORECASE)
"""What is called so may end the program, and is pressed last."""
PRESSED = frozenset({
    "activated", "clicked", "currentIndexChanged", "pressed", "released", "returnPressed",
    "sliderReleased", "toggled", "triggered", "valueChanged",
})  # fmt: skip
"""Signals that come when somebody uses a widget."""
PROGRAM = re.compile(r"\.(Tk|CTk|Window|Q\w*Application)\b")
"""What ends with its main loop, by its name."""
OF_QT = re.compile(r"Qt|PySide|qt_binding")
"""A name in a binding of Qt."""
TYPED = re.compile(r"\.(Entry|Combobox|Spinbox|StringVar|Text|CTk(Entry|Textbox|ComboBox))\(\)$")
"""Widgets that give a text, as it is typed."""
WHOLE = re.compile(r"\.(QSlider|QSpinBox|QDial|QScrollBar|QProgressBar)\(\)$")
"""Widgets that give whole numbers, from 0 to 99 where nothing else is said."""
KEY = re.compile(r"<?(?:KeyPress-|Key-)?(?P<key>[A-Za-z0-9]|Up|Down|Left|Right|Return|space)>?")
"""An event of a key."""


def starred(module: str) -> Sequence[str]:
    """Return what `import *` takes of a module."""
    parts = module.split(".")
    ends = (".".join(parts[-length:]) for length in (2, 1))
    named = next((_STARRED[end] for end in ends if end in _STARRED), "").split()
    return [*named, *tk_constants()] if parts[0] == "tkinter" else named


@lru_cache(maxsize=1)
def tk_constants() -> Mapping[str, object]:
    """Return the constants of Tk, as `END`; they are in a module that needs no screen."""
    file = Path(sysconfig.get_path("stdlib"), "tkinter", "constants.py")
    known = runpy.run_path(str(file)) if file.is_file() else {}
    return {name: value for name, value in known.items() if name.isupper()}


def no_screen(module: str) -> str:
    """Return what to do about a library for windows, whose module is not served."""
    return (
        f"a run has no screen: a scenario with `modules: [{{module: {module}}}]` gives windows "
        "whose buttons are pressed once each"
    )


def needs_screen(error: BaseException) -> bool:
    """Return whether an error says that Tk has no screen."""
    return type(error).__name__ == "TclError" and "display" in str(error)
