from setuptools import setup

setup(
    name="press_cell",
    version="1.0.0",
    packages=["press_cell"],
    entry_points={"console_scripts": ["press_feeder = press_cell.press_feeder:main"]},
)
