# SPDX-License-Identifier: GPL-2.0-or-later
from .product import PLUGIN as PLUGIN
from .product import PRODUCTS as PRODUCTS
from .product import availability as availability
from .product import plugin_path as plugin_path
