from setuptools import find_packages, setup

PACKAGE = 'node_runner'

setup(
    name=PACKAGE,
    version='0.1.0',
    packages=find_packages(exclude=['test']),
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml', 'config/fastdds.xml']),
    ],
    install_requires=['setuptools'],
    zip_safe=True,
    maintainer='The Red Queen developers',
    maintainer_email='red-queen@example.org',
    description='Starts, spins and cleanly ends a ROS 2 node; the loop all nodes here share.',
    license='Apache-2.0',
    extras_require={'test': ['pytest']},
    entry_points={'console_scripts': []},
)
