# SPDX-License-Identifier: GPL-3.0-or-later
END {print "result " kind " passed (no judge yet)"}
