from setuptools import find_packages, setup

PACKAGE = 'coevo_manager'

setup(
    name=PACKAGE,
    version='0.1.0',
    packages=find_packages(exclude=['test']),
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
    ],
    install_requires=['setuptools'],
    zip_safe=True,
    maintainer='The Red Queen developers',
    maintainer_email='red-queen@example.org',
    description='Competitive co-evolution of predators and prey: episodes, algorithms, analysis and their executables.',
    license='Apache-2.0',
    extras_require={'test': ['pytest']},
    entry_points={
        'console_scripts': [
            'evaluator = coevo_manager.evaluator:main',
            'evolve = coevo_manager.evolve:main',
            'manager = coevo_manager.manager:main',
        ],
    },
)
