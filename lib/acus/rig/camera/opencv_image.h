// For the sources of this module that call OpenCV: its types stay out of headers.
#pragma once

#include <string>

#include "acus/rig/camera/image.h"

namespace cv {
class Mat;
}

namespace acus::camera {

/// A header on the image's pixels, not a copy: it must not outlive them or be written to if the
/// image is const.
cv::Mat MatOf(const Image& image);

/// OpenCV would take all cores for each image, at the cost of whoever feels forces meanwhile.
/// Holds for the whole process.
void HoldOpenCvToOneThread();

/// The number that OpenCV gives to a dictionary. @throws InputError for another name.
int OpenCvDictionary(const std::string& name);
/// How many markers it has. @throws InputError for another name.
int DictionarySize(const std::string& name);

}  // namespace acus::camera
