/* tumble/version.h - the version of firmware and programs.
 *
 * Written by tools/objects/generate from the file VERSION; not to be edited.
 */
#ifndef TUMBLE_VERSION_H
#define TUMBLE_VERSION_H

#define TUMBLE_VERSION "0.2.0"

#endif
