# SPDX-License-Identifier: GPL-2.0-or-later
from .build import Status as Status
from .build import availability as availability
from .build import build_all as build_all
from .build import build_for as build_for
from .build import library_path as library_path
from .cache import cache_folder as cache_folder
from .compiler import find_compiler as find_compiler
from .product import Product as Product
from .product import Wheel as Wheel
