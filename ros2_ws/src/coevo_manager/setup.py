from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = 'coevo_manager'

setup(
    name=PACKAGE,
    version='0.1.0',
    packages=find_packages(exclude=['test']),
    package_data={PACKAGE: ['analysis/report/assets/*', 'dashboard/assets/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        (f'share/{PACKAGE}/launch', [str(path) for path in Path('launch').iterdir()]),
    ],
    install_requires=['setuptools'],
    zip_safe=True,
    maintainer='The Red Queen developers',
    maintainer_email='red-queen@example.org',
    description='Competitive co-evolution of predators and prey: episodes, algorithms, analysis.',
    license='Apache-2.0',
    extras_require={'test': ['pytest']},
    entry_points={
        'console_scripts': [
            'analyze = coevo_manager.analysis.command:main',
            'campaign = coevo_manager.runs.campaign:main',
            'dashboard = coevo_manager.dashboard.command:main',
            'episodes = coevo_manager.recording.episodes:main',
            'evaluator = coevo_manager.evaluators.evaluator:main',
            'evolve = coevo_manager.runs.evolve:main',
            'export = coevo_manager.export:main',
            'manager = coevo_manager.runs.manager:main',
            'record = coevo_manager.recording.record:main',
            'replay = coevo_manager.recording.replay:main',
            'transfer = coevo_manager.analysis.transfer.command:main',
        ],
    },
)
