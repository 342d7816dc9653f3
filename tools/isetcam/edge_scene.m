function [scene, as_created] = edge_scene()
% The slanted edge under equal energy: 513 x 513 pixels, slope 7/3, 5 degrees wide, at 1.2 m, with a mean of 75 cd/m2.
as_created = sceneCreate('slanted bar', 512, 7/3);
scene = sceneSet(sceneSet(as_created, 'fov', 5), 'distance', 1.2);
scene = sceneAdjustLuminance(scene, 75);
end
