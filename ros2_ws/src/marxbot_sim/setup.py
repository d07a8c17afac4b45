from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = 'marxbot_sim'

setup(
    name=PACKAGE,
    version='0.1.0',
    packages=find_packages(exclude=['test']),
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        (f'share/{PACKAGE}/urdf', [str(path) for path in Path('urdf').iterdir()]),
        (f'share/{PACKAGE}/rviz', [str(path) for path in Path('rviz').iterdir()]),
        (f'share/{PACKAGE}/foxglove', [str(path) for path in Path('foxglove').iterdir()]),
        (f'share/{PACKAGE}/launch', [str(path) for path in Path('launch').iterdir()]),
    ],
    install_requires=['setuptools'],
    zip_safe=True,
    maintainer='The Red Queen developers',
    maintainer_email='red-queen@example.org',
    description='The MarxBot robot and its arena: sensors, motion and the simulator node.',
    license='Apache-2.0',
    extras_require={'test': ['pytest']},
    entry_points={'console_scripts': ['simulator = marxbot_sim.simulator:main']},
)
