from glob import glob

from setuptools import find_packages, setup

PACKAGE = 'marxbot_sim'

setup(
    name=PACKAGE,
    version='0.1.0',
    packages=find_packages(exclude=['test']),
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        (f'share/{PACKAGE}/urdf', glob('urdf/*')),
        (f'share/{PACKAGE}/rviz', glob('rviz/*')),
        (f'share/{PACKAGE}/foxglove', glob('foxglove/*')),
        (f'share/{PACKAGE}/launch', glob('launch/*')),
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
