from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = 'neuro_controller'

setup(
    name=PACKAGE,
    version='0.1.0',
    packages=find_packages(exclude=['test']),
    package_data={PACKAGE: ['champions/*.npz']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        (
            f'share/{PACKAGE}/examples/predator_robot',
            [str(path) for path in Path('examples/predator_robot').iterdir()],
        ),
        (f'share/{PACKAGE}/launch', [str(path) for path in Path('launch').iterdir()]),
        (f'share/{PACKAGE}/config', [str(path) for path in Path('config').iterdir()]),
    ],
    install_requires=['setuptools'],
    zip_safe=True,
    maintainer='The Red Queen developers',
    maintainer_email='red-queen@example.org',
    description='The recurrent neural controller of a MarxBot, its genome and its nodes.',
    license='Apache-2.0',
    extras_require={'test': ['pytest']},
    entry_points={
        'console_scripts': [
            'controller = neuro_controller.controller:main',
            'genome_server = neuro_controller.genome_server:main',
        ],
    },
)
